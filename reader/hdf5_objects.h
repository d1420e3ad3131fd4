// Arrays of numbers and attributes of HDF5 files.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "source.h"

namespace palpa::reader {

/// Identifier of the library, closed with its owner.
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

/// Lengths of an array's indices, slowest first.
struct Shape {
  std::vector<std::int64_t> lengths;
  RawType type = RawType::float32;
};

/// Reason why a data set is no array of numbers in this file alone; empty if it is, and `shape` is filled.
std::string shape_of(hid_t dataset, Shape& shape);

/// True if fewer bytes are stored than the numbers take, without a filter that compresses: HDF5 would read beyond them.
bool is_stored_short(hid_t dataset);

struct FoundArray {
  std::string path;
  Shape shape;
};
/// Arrays of three or more indices, at most 200.
std::vector<FoundArray> arrays_in(hid_t file);

/// Text of a string attribute, at most 1000 bytes; empty if absent.
std::string text_attribute(hid_t object, const char* name);

/// Numbers of an attribute; none if absent, an empty list if it holds other types or over 1000.
std::optional<std::vector<double>> numbers_attribute(hid_t object, const char* name);

/// Texts of an attribute with `count` texts; else none.
std::vector<std::string> texts_attribute(hid_t object, const char* name, std::size_t count);

/// First scale of each of an array's indices, open or not (the convention of dimension scales).
std::vector<Handle> dimension_scales(hid_t dataset, std::size_t rank);

}  // namespace palpa::reader
