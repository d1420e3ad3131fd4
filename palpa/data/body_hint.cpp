#include "palpa/data/body_hint.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

namespace palpa {
namespace {

struct Word {
  std::string_view word;
  const char* part;
  bool whole;  // the word itself; else also as a part, as "arter" in "arteries"
};
constexpr Word words[] = {
    {"vessel", "blood vessel", false},
    {"vascul", "blood vessel", false},
    {"arter", "blood vessel", false},
    {"aort", "blood vessel", false},
    {"carotid", "blood vessel", false},
    {"aneur", "blood vessel", false},
    {"blood", "blood vessel", false},
    {"coronar", "blood vessel", false},
    {"shearstress", "blood vessel", false},
    {"wss", "blood vessel", true},
    {"vein", "blood vessel", true},
    {"lumen", "blood vessel", true},
    {"stent", "blood vessel", true},
    {"brain", "head", false},
    {"skull", "head", false},
    {"crani", "head", false},
    {"cerebr", "head", false},
    {"head", "head", true},
    {"cardi", "heart", false},
    {"ventric", "heart", false},
    {"heart", "heart", true},
    {"patient", "part of a body", false},
    {"lung", "part of a body", true},
    {"liver", "part of a body", true},
    {"knee", "part of a body", true},
    {"spine", "part of a body", true},
    {"airway", "part of a body", false},
    {"mri", "part of a body", true},
    {"ct", "part of a body", true},
};

bool has(const std::string& name, const Word& word) {
  const auto letter = [&](std::size_t at) { return at < name.size() && std::isalpha(static_cast<unsigned char>(name[at])); };
  for (std::size_t at = name.find(word.word); at != std::string::npos; at = name.find(word.word, at + 1)) {
    if (!word.whole || (!letter(at - 1) && !letter(at + word.word.size()))) return true;
  }
  return false;
}

/// Lower case, without separators of words: "shear stress".
std::string plain(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const std::string_view parted : {"shear_stress", "shear-stress", "shear stress"}) {
    if (const auto at = name.find(parted); at != std::string::npos) name.erase(at + 5, 1);
  }
  return name;
}

}  // namespace

std::optional<BodyHint> too_long_for(const Volume& volume, const std::vector<std::filesystem::path>& files) {
  if (!volume.length_unit_assumed || !(largest_component(volume.bounds_m().size_m()) > longest_body_m)) return std::nullopt;
  std::vector<std::string> names;
  for (const std::filesystem::path& file : files) names.push_back(place_in_file(file).file.filename().string());
  for (const VolumeField& field : volume.fields) names.push_back(field.name);
  for (const std::string& name : names) {
    const auto found = std::ranges::find_if(words, [said = plain(name)](const Word& word) { return has(said, word); });
    if (found != std::end(words)) return BodyHint{found->part, name};
  }
  return std::nullopt;
}

}  // namespace palpa
