#include "dicom_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <utility>
#include <vector>

namespace palpa::reader {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return small;
}

/// Runs of letters and digits.
std::vector<std::string> words_in(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (is_letter(c) || is_digit(c)) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

bool is_among(std::string_view word, std::initializer_list<std::string_view> list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : std::string(between)) + word;
  return all;
}

/// Words of body parts and techniques, in the languages of protocol names, each between spaces.
constexpr std::string_view radiology_words =
    " abdomen abdominal ankle aorta aortic arm arteries bladder body bone bones bowel brain breast brustkorb calf"
    " cardiac carotid carotis cerebral cerebrum cervical chest clavicle colon coronary cranium cspine elbow extremity"
    " face facial femur fetal fetus finger foot forearm fuss hals hand head heart herz hip humerus iac jaw joint"
    " kidney kidneys knee knie kopf larynx leg liver lower lspine lumbar lung lunge mandible maxilla mouth muscle neck"
    " neuro nose orbit orbits pancreas pelvis becken pituitary prostate pulmonary renal rib ribs sacrum schaedel"
    " schulter shoulder sinus sinuses skull spine spleen sternum temporal testis thigh thorax throat thyroid tibia"
    " tooth teeth trunk tspine upper uterus vessels whole wirbelsaeule wrist wholebody acute adult angio angiogram"
    " angiography arterial asl axial basic bold breathhold cine contrast cor coronal ct cta delayed diff diffusion dti"
    " dual dwi dynamic echo ecg enhanced epi fat fatsat flair flash flow fmri functional gated gradient gre haste"
    " helical helix hires hr infant inversion iso ir late localizer map mip mpr mprage mr mra mri mrcp mrv multi nativ"
    " native noncontrast oblique pc pca pd pediatric perfusion phase phantom plain portal post pre proton qa"
    " quantitative recovery resting routine sag sagittal satfat scan scout screening se sequential space spgr spin"
    " spiral ssfp standard std stir stroke survey swi t1 t1w t2 t2w t2star task tfe tfl thick thin tir tof topogram"
    " tra transversal trauma trufi tse turbo unenhanced venc velocity venous vessel vibe volume weighted with without"
    " 2d 3d 4d headneck neckchest chestabdomen abdomenpelvis chestabdpelvis 4dflow ax ";

/// Words of scanner models, in the format above.
constexpr std::string_view model_words =
    " achieva aera aquilion artis ascend as avanto biograph brightspeed brilliance ct ct750 definition discovery drive"
    " edge elition emotion espree excite explorer force gemini genesis hd750 icct ict ingenia ingenuity intera iqon"
    " lightspeed lumina magnetom mr mr450 mr450w mr750 mr750w mx8000 naeotom optima perspective precision prime prisma"
    " prismafit pro revolution scope sensation signa skyra sola somatom spectral spirit symphony terra titan trio"
    " triotim ultra verio vct vision volumezoom premier prodigy cardiac 15t 3t 7t 16 64 128 256 hd hdx hdxt plus x ";

/// \param word  letters and digits only
bool is_listed(const std::string& word, std::string_view list) { return list.find(" " + word + " ") != std::string_view::npos; }

}  // namespace

std::string format_protocol(std::string_view text) {
  constexpr std::size_t most_words = 10;  // [1] More: long lines; fewer: informative words are lost
  std::vector<std::string> known;
  for (const std::string& word : words_in(text)) {
    const std::string small = lower(word);
    const bool again = !known.empty() && known.back() == small;
    if (known.size() < most_words && !again && is_listed(small, radiology_words)) known.push_back(small);
  }
  return joined(known, " ");
}

bool names_contrast_agent(std::string_view text) {
  const std::vector<std::string> words = words_in(text);
  return !words.empty() && !is_among(lower(words.front()), {"no", "non", "none", "nil", "without", "w", "wo", "n", "ohne",
                                                            "kein", "keine", "nativ", "native", "plain", "0"});
}

std::string format_scanner(std::string_view maker, std::string_view model) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 17> makers{{{"siemens", "Siemens"},
                                                                                         {"ge medical", "GE"},
                                                                                         {"ge healthcare", "GE"},
                                                                                         {"philips", "Philips"},
                                                                                         {"toshiba", "Toshiba"},
                                                                                         {"canon", "Canon"},
                                                                                         {"hitachi", "Hitachi"},
                                                                                         {"fujifilm", "Fujifilm"},
                                                                                         {"shimadzu", "Shimadzu"},
                                                                                         {"bruker", "Bruker"},
                                                                                         {"esaote", "Esaote"},
                                                                                         {"neusoft", "Neusoft"},
                                                                                         {"uih", "United Imaging"},
                                                                                         {"united imaging", "United Imaging"},
                                                                                         {"samsung", "Samsung"},
                                                                                         {"hologic", "Hologic"},
                                                                                         {"carestream", "Carestream"}}};
  const std::string small = lower(maker);
  const auto known =
      std::find_if(makers.begin(), makers.end(), [&](const auto& m) { return small.find(m.first) != std::string::npos; });
  if (known == makers.end()) return {};
  std::vector<std::string> words{std::string(known->second)};
  for (const std::string& word : words_in(model)) {
    if (is_listed(lower(word), model_words)) words.push_back(word);
  }
  return joined(words, " ");
}

std::string format_kernel(std::string_view text) {
  const std::vector<std::string> words = words_in(text);
  if (words.empty()) return {};
  const std::string& first = words.front();
  const std::string small = lower(first);
  if (is_among(small, {"standard", "soft", "bone", "boneplus", "lung", "detail", "edge", "chst", "ultra", "body", "brain"}))
    return small;
  // One to three letters, digits, a letter: H31s, Br40d, FC26; or the letters of Philips alone.
  std::size_t at = 0;
  while (at < first.size() && is_letter(first[at])) ++at;
  const std::size_t letters = at;
  while (at < first.size() && is_digit(first[at])) ++at;
  const std::size_t digits = at - letters;
  const bool of_digits = letters >= 1 && letters <= 2 && digits >= 1 && digits <= 2 && first.size() - at <= 1;
  return of_digits || is_among(first, {"A", "B", "C", "D", "E", "F", "L", "UA", "UB", "UC", "YA", "YB", "YC"}) ? first : "";
}

std::string format_sequence(std::string_view kinds, std::string_view variants, std::string_view extent, std::string_view name) {
  std::vector<std::string> kind, variant;
  for (const std::string& word : words_in(variants)) {
    for (const auto& [code, words] : {std::pair{"SP", "spoiled"},
                                      {"SS", "steady-state"},
                                      {"MTC", "magnetization-transfer"},
                                      {"MP", "magnetization-prepared"}}) {
      if (word == code) variant.emplace_back(words);
    }
  }
  for (const std::string& word : words_in(kinds)) {
    for (const auto& [code, words] :
         {std::pair{"SE", "spin echo"}, {"GR", "gradient echo"}, {"EP", "echo planar"}, {"IR", "inversion recovery"}}) {
      if (word == code) kind.emplace_back(words);
    }
  }
  if (kind.empty()) return {};
  std::string words = extent == "2D" || extent == "3D" ? std::string(extent) + " " : "";
  for (const std::string& of : variant) words += of + " ";
  words += joined(kind, ", ");

  // Names in the form of Siemens: a known abbreviation, then dimensions and numbers, as in *tfl3d1_16ns.
  while (!name.empty() && name.front() == '*') name.remove_prefix(1);
  while (!name.empty() && name.back() == ' ') name.remove_suffix(1);
  for (const std::string_view start :
       {"tfl", "fl", "tse", "tir", "se", "epfid", "epse", "ep", "spcir", "spc", "h2d", "fi", "tfi"}) {
    if (name.substr(0, start.size()) != start) continue;
    const std::string_view rest = name.substr(start.size());
    if (rest.size() <= 12 && rest.find_first_not_of("0123456789_#bdnrs") == std::string_view::npos &&
        rest.find_first_of("0123456789") != std::string_view::npos) {
      return words + " (" + std::string(name) + ")";
    }
  }
  return words;
}

std::string format_image_type(std::string_view text) {
  const std::string upper = "\\" + std::string(text) + "\\";
  for (const auto& [code, words] : {std::pair{"\\PHASE MAP\\", "phase map"},
                                    {"\\VELOCITY MAP\\", "velocity map"},
                                    {"\\VELOCITY\\", "velocity map"},
                                    {"\\P\\", "phase map"},
                                    {"\\ADC\\", "ADC map"},
                                    {"\\FA\\", "FA map"},
                                    {"\\TRACEW\\", "diffusion, trace-weighted"},
                                    {"\\MIP\\", "maximum intensity projection"},
                                    {"\\PROJECTION IMAGE\\", "projection"},
                                    {"\\LOCALIZER\\", "localizer"}}) {
    if (upper.find(code) != std::string::npos) return words;
  }
  return {};
}

}  // namespace palpa::reader
