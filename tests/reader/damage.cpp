#include "damage.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>

#include "files.h"

namespace palpa::test {
namespace {

void write(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

}  // namespace

void Damage::put(const fs::path& file, const std::string& bytes) {
  switch (below(40)) {
    case 0: return write(file, "");
    case 1: return fs::create_symlink(file.filename(), file);
    case 2: return static_cast<void>(fs::create_directory(file));
    case 3: return;
    case 4: return write(file, bytes + bytes.substr(0, below(1 << 16)));
    default: return write(file, damaged(bytes));
  }
}

std::string Damage::damaged(std::string bytes) {
  if (bytes.empty()) return bytes;
  // Headers are small and matter most: half of the damage goes to the first 400 bytes.
  const auto place = [&] { return below(2) == 0 ? below(std::min<std::size_t>(bytes.size(), 400)) : below(bytes.size()); };
  switch (below(7)) {
    case 0: bytes.resize(place()); break;
    case 1:
      for (int n = 0; n < 4; ++n) bytes[place()] ^= static_cast<char>(1 << below(8));
      break;
    case 2:
      for (int n = 0; n < 3; ++n) bytes[place()] = static_cast<char>("09-9e\xff"[below(6)]);
      break;
    case 3: bytes.erase(place(), 1 + below(16)); break;
    case 4: bytes.insert(place(), std::string(1 + below(16), static_cast<char>(below(256)))); break;
    case 5: {
      const std::size_t at = place();
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), std::min<std::size_t>(bytes.size() - at, 1 + below(64)),
                  '\0');
      break;
    }
    default: change_number(bytes); break;
  }
  return bytes;
}

// Changes a number of a text header; of a binary header, four bytes.
void Damage::change_number(std::string& bytes) {
  static constexpr const char* numbers[] = {"0",        "-1",         "1",          "7",     "65536",
                                            "99999999", "2147483647", "4294967296", "1e308", "nan"};
  const std::size_t near = below(std::min<std::size_t>(bytes.size(), 2000));
  const std::size_t from = bytes.find_first_of("0123456789", near);
  if (from != std::string::npos && from < near + 40) {
    const std::size_t end = std::min(bytes.find_first_not_of("0123456789.", from), bytes.size());
    bytes.replace(from, end - from, numbers[below(std::size(numbers))]);
    return;
  }
  static constexpr std::uint32_t values[] = {0, 1, 0x7fffffff, 0xffffffff, 0x01000000, 65536};
  const std::string four = bytes_of(values[below(std::size(values))], below(2) == 0);
  for (std::size_t n = 0; n < 4 && near + n < bytes.size(); ++n) bytes[near + n] = four[n];
}

}  // namespace palpa::test
