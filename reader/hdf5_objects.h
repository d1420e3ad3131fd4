// What HDF5 files are made of, as far as it is asked for here: arrays of numbers and attributes.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "source.h"

namespace palpa::reader {

/// An identifier of the library, closed with its owner.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const noexcept { return id_; }
  bool is_open() const noexcept { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

hid_t memory_type(RawType type);

/// The lengths of an array's indices, slowest first.
struct Shape {
  std::vector<std::int64_t> lengths;
  RawType type = RawType::float32;
};

/// Why this data set is not an array of numbers that can be read from this file alone; empty if it is, and `shape` is filled.
std::string shape_of(hid_t dataset, Shape& shape);

/// Whether less is stored than the numbers take, and no filter that could have made it smaller: HDF5 would read on behind it,
/// in memory that holds anything.
bool is_stored_short(hid_t dataset);

struct FoundArray {
  std::string path;
  Shape shape;
};
/// The arrays of three or more indices, at most 200.
std::vector<FoundArray> arrays_in(hid_t file);

/// The text of a string attribute of an object; empty if it has none. Longer text is cut after 1000 bytes.
std::string text_attribute(hid_t object, const char* name);

/// The numbers of an attribute; none if the object does not have it, no numbers in it if it holds others, or over 1000.
std::optional<std::vector<double>> numbers_attribute(hid_t object, const char* name);

/// The texts of an attribute that holds `count` of them; none if it does not.
std::vector<std::string> texts_attribute(hid_t object, const char* name, std::size_t count);

/// The first scale of each of an array's indices, open or not (the convention of dimension scales).
std::vector<Handle> dimension_scales(hid_t dataset, std::size_t rank);

}  // namespace palpa::reader
