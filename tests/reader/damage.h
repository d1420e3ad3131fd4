// Damage to files, as by disks, networks and people.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

namespace palpa::test {

/// Damages bytes and files at random: equal choices give equal damage.
class Damage {
 public:
  /// \param below  returns a number from 0 to its argument less one; the argument is above 0
  explicit Damage(std::function<std::size_t(std::size_t)> below) : below_(std::move(below)) {}

  std::size_t below(std::size_t n) { return below_(n); }

  /// Cut off, bits flipped, characters of the header and its numbers changed, bytes removed, inserted or zeroed.
  std::string damaged(std::string bytes);
  /// Replaces a file by damage to this content: as above, or empty, longer, a link to itself, a folder, gone.
  void put(const std::filesystem::path& file, const std::string& bytes);

 private:
  void change_number(std::string& bytes);

  std::function<std::size_t(std::size_t)> below_;
};

}  // namespace palpa::test
