// Damage to files, as disks, networks and people do it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

namespace palpa::test {

/// Damages bytes and files at random: the same choices give the same damage.
class Damage {
 public:
  /// \param below  gives a number from 0 to its argument, which is above 0, less one
  explicit Damage(std::function<std::size_t(std::size_t)> below) : below_(std::move(below)) {}

  std::size_t below(std::size_t n) { return below_(n); }

  /// Cut off, bits flipped, characters of the header and its numbers changed, bytes taken out, put in or zeroed.
  std::string damaged(std::string bytes);
  /// Puts damage in the place of a file with this content: as above, or empty, longer, a link to itself, a folder, gone.
  void put(const std::filesystem::path& file, const std::string& bytes);

 private:
  void change_number(std::string& bytes);

  std::function<std::size_t(std::size_t)> below_;
};

}  // namespace palpa::test
