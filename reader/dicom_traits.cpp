#include "dicom_traits.h"

#include <vtkDICOMDictionary.h>
#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMSequence.h>
#include <vtkDICOMTagPath.h>
#include <vtkDICOMValue.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>
#include <utility>

namespace palpa::reader {
namespace {

using VR = vtkDICOMVR;

enum class Form : std::uint8_t {
  numbers,
  words,
  words_from_third,  ///< "M\\FFE" of "ORIGINAL\\PRIMARY\\M\\FFE"
  third_word,
  first_two_words,
  of_frame,   ///< one number per frame of the file
  direction,  ///< of a diffusion gradient, one sequence deeper than all others
  b_value,    ///< first number; GE adds 10⁹ to it
  component,  ///< word of the standard, its first letter, or its number
  time_step   ///< frame number, if the file counts its frames in time
};

/// Private elements of a maker, from before the standard had an element.
struct OfMaker {
  const char* creator;                   ///< of the block of private elements
  std::uint16_t group = 0, element = 0;  ///< of the block
  VR type;                               ///< also for elements without a type
  int count = 1;                         ///< of consecutive elements with a number each
};

struct Row {
  Attribute attribute;
  Form form;
  std::vector<std::pair<DC::EnumType, VR>> elements{};  ///< the first present element is read
  std::vector<OfMaker> of_makers{};                     ///< read if all of these are absent
};

constexpr double measured = 5e-3;  ///< [1] of nominal values that scanners round in several ways

std::vector<Row> kinds() {
  using enum Apart;
  using enum Form;
  return {
      {{"segment"}, numbers, {{DC::ReferencedSegmentNumber, VR::US}}},
      {{"echo time", "ms", kind, measured}, numbers, {{DC::EffectiveEchoTime, VR::FD}, {DC::EchoTime, VR::DS}}},
      {{"echo number"}, numbers, {{DC::EchoNumbers, VR::IS}}},
      {{"temporal position", "", kind, 0, true},
       numbers,
       {{DC::TemporalPositionIndex, VR::UL}, {DC::TemporalPositionIdentifier, VR::IS}}},
      {{"complex component"},
       component,
       {{DC::ComplexImageComponent, VR::CS}},
       {{"GEMS_PARM_01", 0x0043, 0x2f, VR::SS}, {"Philips MR Imaging DD 001", 0x2005, 0x11, VR::CS}}},
      {{"frame type"}, words_from_third, {{DC::FrameType, VR::CS}}},
      {{"image type"}, third_word, {{DC::ImageType, VR::CS}}},
      {{"b-value", "s/mm²", kind, measured},
       b_value,
       {{DC::DiffusionBValue, VR::FD}},
       {{"GEMS_PARM_01", 0x0043, 0x39, VR::IS},
        {"Philips Imaging DD 001", 0x2001, 0x03, VR::FL},
        {"SIEMENS MR HEADER", 0x0019, 0x0c, VR::IS},
        {"Image Private Header", 0x0065, 0x09, VR::FD}}},
      {{"gradient direction", "", kind, 0.01},
       direction,
       {{DC::DiffusionGradientOrientation, VR::FD}},
       {{"GEMS_ACQU_01", 0x0019, 0xbb, VR::DS, 3},
        {"Philips MR Imaging DD 001", 0x2005, 0xb0, VR::FL, 3},
        {"SIEMENS MR HEADER", 0x0019, 0x0e, VR::FD},
        {"Image Private Header", 0x0065, 0x37, VR::FD}}},
      {{"diffusion directionality"},
       words,
       {{DC::DiffusionDirectionality, VR::CS}},
       {{"Philips Imaging DD 001", 0x2001, 0x04, VR::CS}, {"SIEMENS MR HEADER", 0x0019, 0x0d, VR::CS}}},
      {{"energy window"}, of_frame, {{DC::EnergyWindowVector, VR::US}}},
      {{"detector"}, of_frame, {{DC::DetectorVector, VR::US}}},
      {{"phase"}, of_frame, {{DC::PhaseVector, VR::US}}},
      {{"rotation"}, of_frame, {{DC::RotationVector, VR::US}}},
      {{"R-R interval"}, of_frame, {{DC::RRIntervalVector, VR::US}}},
      {{"time slot"}, of_frame, {{DC::TimeSlotVector, VR::US}}},
      {{"time slice"}, of_frame, {{DC::TimeSliceVector, VR::US}}},
      {{"angular view"}, of_frame, {{DC::AngularViewVector, VR::US}}},
      {{"velocity direction", "", kind, 0.01},
       numbers,
       {{DC::VelocityEncodingDirection, VR::FD}},
       {{"GEMS_PARM_01", 0x0043, 0x30, VR::SS}}},
      {{"ASL context"}, words, {{DC::ASLContext, VR::CS}}},
      {{"contrast phase"}, words, {{DC::ContrastBolusAgentPhase, VR::CS}}},
      {{"contrast agent number"}, numbers, {{DC::ContrastBolusAgentNumber, VR::US}}},
      {{"cardiac phase", "%", kind, measured}, numbers, {{DC::NominalPercentageOfCardiacPhase, VR::FL}}},
      {{"respiratory phase", "%", kind, measured}, numbers, {{DC::NominalPercentageOfRespiratoryPhase, VR::FL}}},
      {{"acquisition contrast"}, words, {{DC::AcquisitionContrast, VR::CS}}},
      {{"phase contrast"}, words, {{DC::PhaseContrast, VR::CS}}},
      {{"data type"}, words, {{DC::DataType, VR::CS}}},
      {{"unit of values"}, words, {{DC::Units, VR::CS}}},
      {{"rescale type"}, words, {{DC::RescaleType, VR::LO}}},
      {{"optical path"}, words, {{DC::OpticalPathIdentifier, VR::SH}}},
      {{"time step"}, time_step, {{DC::FrameIncrementPointer, VR::AT}}},
  };
}

std::vector<Row> settings() {
  using enum Apart;
  using enum Form;
  return {
      {{"inversion time", "ms", setting, measured, false, true},
       numbers,
       {{DC::InversionTimes, VR::FD}, {DC::InversionTime, VR::DS}}},
      {{"flip angle", "°", setting, measured, false, true}, numbers, {{DC::FlipAngle, VR::DS}}},
      {{"repetition time", "ms", setting, measured}, numbers, {{DC::RepetitionTime, VR::DS}}},
      {{"tube voltage", "kV", setting, measured, false, true}, numbers, {{DC::KVP, VR::DS}}},
      {{"energy weighting", "", setting, measured}, numbers, {{DC::EnergyWeightingFactor, VR::FL}}},
      {{"velocity range", "cm/s", setting, measured}, numbers, {{DC::VelocityEncodingMaximumValue, VR::FD}}},
      {{"slice thickness", "mm", setting, measured}, numbers, {{DC::SliceThickness, VR::DS}}},
      {{"stack", "", setting}, words, {{DC::StackID, VR::SH}}},
      {{"kernel", "", setting, 0, false, true}, words, {{DC::ConvolutionKernel, VR::SH}}},
      {{"reconstruction", "", setting}, words, {{DC::ReconstructionAlgorithm, VR::CS}}},
      {{"filter", "", setting}, words, {{DC::FilterType, VR::SH}}},
      {{"sequence", "", setting}, words, {{DC::PulseSequenceName, VR::SH}, {DC::SequenceName, VR::SH}}},
      {{"scan options", "", setting}, words, {{DC::ScanOptions, VR::CS}}},
      {{"contrast agent", "", setting, 0, false, true}, words, {{DC::ContrastBolusAgent, VR::LO}}},
      {{"magnetization transfer", "", setting}, words, {{DC::MagnetizationTransfer, VR::CS}}},
      {{"suppression", "", setting}, words, {{DC::SpectrallySelectedSuppression, VR::CS}}},
      {{"receive coil", "", setting}, words, {{DC::ReceiveCoilName, VR::SH}}},
      {{"transmit coil", "", setting}, words, {{DC::TransmitCoilName, VR::SH}}},
      {{"cardiac cycle", "", setting}, words, {{DC::CardiacCyclePosition, VR::CS}}},
      {{"respiratory cycle", "", setting}, words, {{DC::RespiratoryCyclePosition, VR::CS}}},
      // Makers write varied notes here, which may differ from slice to slice.
      {{"notes of the image type", "", setting}, words_from_third, {{DC::ImageType, VR::CS}}},
      {{"original or derived", "", setting}, first_two_words, {{DC::FrameType, VR::CS}, {DC::ImageType, VR::CS}}},
  };
}

std::vector<Row> moments() {
  using enum Apart;
  using enum Form;
  return {
      {{"trigger time", "ms", moment},
       numbers,
       {{DC::NominalCardiacTriggerDelayTime, VR::FD},
        {DC::ActualCardiacTriggerDelayTime, VR::FD},
        {DC::NominalRespiratoryTriggerDelayTime, VR::FD},
        {DC::TriggerTime, VR::DS}}},
      {{"time offset", "s", moment}, numbers, {{DC::TemporalPositionTimeOffset, VR::FD}}},
      {{"reference time", "ms", moment}, numbers, {{DC::FrameReferenceTime, VR::DS}}},
      {{"acquisition number", "", number}, numbers, {{DC::FrameAcquisitionNumber, VR::US}, {DC::AcquisitionNumber, VR::IS}}},
      {{"acquisition time", "", number},
       words,
       {{DC::FrameAcquisitionDateTime, VR::DT},
        {DC::FrameReferenceDateTime, VR::DT},
        {DC::AcquisitionDateTime, VR::DT},
        {DC::AcquisitionTime, VR::TM}}},
      {{"instance number", "", number}, numbers, {{DC::InstanceNumber, VR::IS}}},
  };
}

/// Order in which frames are numbered: echoes before moments.
const std::vector<Row>& rows() {
  static const std::vector<Row> all = [] {
    std::vector<Row> in_order = kinds();
    for (const auto& more : {settings(), moments()}) in_order.insert(in_order.end(), more.begin(), more.end());
    return in_order;
  }();
  return all;
}

/// Dimensions of a file beyond the attributes above.
constexpr int most_dimensions = 8;
constexpr std::array<Attribute, most_dimensions> dimensions{{{"dimension 1", "", Apart::kind, 0, true},
                                                             {"dimension 2", "", Apart::kind, 0, true},
                                                             {"dimension 3", "", Apart::kind, 0, true},
                                                             {"dimension 4", "", Apart::kind, 0, true},
                                                             {"dimension 5", "", Apart::kind, 0, true},
                                                             {"dimension 6", "", Apart::kind, 0, true},
                                                             {"dimension 7", "", Apart::kind, 0, true},
                                                             {"dimension 8", "", Apart::kind, 0, true}}};

/// Elements for position, time, scale and display of numbers, or names.
bool is_no_kind(unsigned tag) {
  static const std::set<unsigned> tags{
      0x00080022, 0x00080023, 0x0008002a, 0x00080032, 0x00080033, 0x00181060, 0x00189073, 0x00189074, 0x00189151, 0x00189220,
      0x00189327, 0x00200012, 0x00200013, 0x00200032, 0x00200037, 0x00201041, 0x00209056, 0x00209057, 0x00209128, 0x00209153,
      0x00209156, 0x00209157, 0x00209158, 0x00209252, 0x00209254, 0x00209255, 0x00209301, 0x0020930d, 0x00281050, 0x00281051,
      0x00281052, 0x00281053, 0x00281054, 0x00281055, 0x00281056, 0x0040072a, 0x0040073a, 0x0040074a, 0x0048021e, 0x0048021f};
  return tags.count(tag) > 0;
}

/// True if a dimension that points to an element counts positions.
bool is_place(unsigned tag) {
  static const std::set<unsigned> tags{0x00200032, 0x00200037, 0x00201041, 0x00209057, 0x00209301, 0x0040072a,
                                       0x0040073a, 0x0040074a, 0x0048021e, 0x0048021f, 0x00200013, 0x00209156};
  return tags.count(tag) > 0;
}

unsigned number_of(const vtkDICOMTag& tag) { return static_cast<unsigned>(tag.GetGroup()) << 16 | tag.GetElement(); }

std::vector<double> numbers_in(const vtkDICOMValue& value) {
  std::vector<double> numbers(value.GetNumberOfValues());
  if (!numbers.empty()) value.GetValues(numbers.data(), numbers.size());
  if (!std::ranges::all_of(numbers, [](double n) { return std::isfinite(n); })) numbers.clear();
  return numbers;
}

/// Words [first, last) of a value.
std::string words_in(const vtkDICOMValue& value, std::size_t first, std::size_t last) {
  std::string words;
  for (std::size_t n = first; n < std::min(last, value.GetNumberOfValues()); ++n) {
    words += (words.empty() ? "" : "\\") + value.GetString(n);
  }
  return words;
}

/// True if the frames of a file without functional groups are a sequence in time.
bool counts_time(const vtkDICOMValue& pointer) {
  for (std::size_t n = 0; n < pointer.GetNumberOfValues(); ++n) {
    const unsigned tag = number_of(pointer.GetTag(n));
    if (tag == 0x00181063 || tag == 0x00181065) return true;  // FrameTime, FrameTimeVector
  }
  return false;
}

/// Standard name of a complex component that a maker stores as a number or a letter.
std::string component_of(const vtkDICOMValue& value) {
  static const std::array<std::string, 4> names{"MAGNITUDE", "PHASE", "REAL", "IMAGINARY"};
  const std::string word = words_in(value, 0, 1);
  if (value.GetVR() == VR::SS) {
    const int n = value.AsInt();
    return n >= 0 && n < 4 ? names[static_cast<std::size_t>(n)] : word;
  }
  const auto* const name = std::ranges::find_if(names, [&](const std::string& n) { return word == n.substr(0, 1); });
  return name != names.end() ? *name : word;
}

/// First b-value, to which GE may add 10⁹.
std::vector<double> b_value_in(const vtkDICOMValue& value) {
  constexpr double marked = 1e6, mark = 1e5;
  std::vector<double> numbers = numbers_in(value);
  if (numbers.size() > 1) numbers.resize(1);
  for (double& b : numbers) b = b > marked ? std::fmod(b, mark) : b;
  return numbers;
}

/// Value with `type`, for a file without types: numbers from their bytes, all else from its text.
vtkDICOMValue typed(const vtkDICOMValue& value, VR type) {
  if (value.GetVR() != VR::UN) return value;
  const auto* const bytes = reinterpret_cast<const char*>(value.GetUnsignedCharData());
  const std::size_t size = bytes == nullptr ? 0 : value.GetVL();
  const auto numbers = [&]<class T>(T) {
    std::vector<T> all(size / sizeof(T));
    if (!all.empty()) std::memcpy(all.data(), bytes, all.size() * sizeof(T));
    return vtkDICOMValue(type, all.data(), all.size());
  };
  if (type == VR::FD) return numbers(double{});
  if (type == VR::FL) return numbers(float{});
  if (type == VR::SS) return numbers(short{});
  std::string text(bytes == nullptr ? "" : bytes, size);
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  return {type, text};
}

/// Trait of a frame from one element; without numbers and words: none.
Trait trait_of(const Row& row, const vtkDICOMValue& value, int frame, int frames) {
  constexpr std::size_t all = 1'000'000;
  Trait trait;
  const auto n = static_cast<std::size_t>(frame);
  switch (row.form) {
    case Form::numbers:
    case Form::direction: trait.numbers = numbers_in(value); break;
    case Form::b_value: trait.numbers = b_value_in(value); break;
    case Form::words: trait.words = words_in(value, 0, all); break;
    case Form::component: trait.words = component_of(value); break;
    case Form::words_from_third: trait.words = words_in(value, 2, all); break;
    case Form::third_word: trait.words = words_in(value, 2, 3); break;
    case Form::first_two_words: trait.words = words_in(value, 0, 2); break;
    case Form::of_frame:
      if (value.GetNumberOfValues() == static_cast<std::size_t>(frames)) trait.numbers = {value.GetDouble(n)};
      break;
    case Form::time_step:
      if (frames > 1 && counts_time(value)) trait.numbers = {static_cast<double>(frame)};
      break;
  }
  return trait;
}

/// Trait of an image from private elements.
Trait trait_of_maker(const Row& row, vtkDICOMMetaData& headers, int file) {
  for (const OfMaker& of : row.of_makers) {
    Trait trait;
    for (int n = 0; n < of.count; ++n) {
      const vtkDICOMTag tag =
          headers.ResolvePrivateTag(file, vtkDICOMTag(of.group, static_cast<unsigned short>(of.element + n)), of.creator);
      const vtkDICOMValue value = tag.GetGroup() == of.group ? typed(headers.Get(file, tag), of.type) : vtkDICOMValue();
      if (!value.IsValid()) break;
      Trait part = trait_of(row, value, 0, 1);
      trait.words += part.words;
      trait.numbers.insert(trait.numbers.end(), part.numbers.begin(), part.numbers.end());
    }
    if (!trait.words.empty() || !trait.numbers.empty()) return trait;
  }
  return {};
}

/// Adds traits from the file's dimensions that none of the `known` elements covers.
void add_dimensions(vtkDICOMMetaData& headers, int file, int frame, const std::set<unsigned>& known, std::vector<Trait>& to) {
  const vtkDICOMValue& sequence = headers.Get(file, DC::DimensionIndexSequence);
  const std::vector<double> indices = numbers_in(headers.Get(file, frame, DC::DimensionIndexValues));
  const std::size_t count = std::min({sequence.GetNumberOfValues(), indices.size(), static_cast<std::size_t>(most_dimensions)});
  for (std::size_t d = 0; d < count; ++d) {
    const vtkDICOMItem& item = sequence.GetSequenceData()[d];
    const unsigned pointer = number_of(item.Get(DC::DimensionIndexPointer).GetTag(0));
    if (is_place(pointer) || known.count(pointer) > 0) continue;
    to.push_back({static_cast<int>(rows().size() + d), {indices[d]}});
  }
}

void add_rest(const vtkDICOMItem& item, std::vector<std::string>& to) {
  constexpr std::size_t most = 200;  // per frame; cuts endless headers
  for (vtkDICOMDataElementIterator e = item.Begin(); e != item.End() && to.size() < most; ++e) {
    const vtkDICOMValue& value = e->GetValue();
    const unsigned tag = number_of(e->GetTag());
    const VR type = value.GetVR();
    if (is_no_kind(tag) || type == VR::UI || type == VR::DT || type == VR::TM || type == VR::DA) continue;
    if (type == VR::SQ) {
      for (std::size_t n = 0; n < value.GetNumberOfValues(); ++n) add_rest(value.GetSequenceData()[n], to);
    } else {
      char place[16];
      std::snprintf(place, sizeof place, "(%04x,%04x)", tag >> 16, tag & 0xffff);
      to.push_back(place + words_in(value, 0, 100));
    }
  }
}

}  // namespace

int attributes() { return static_cast<int>(rows().size()) + most_dimensions; }

const Attribute& attribute(int number) {
  const auto n = static_cast<std::size_t>(number);
  return n < rows().size() ? rows()[n].attribute : dimensions[n - rows().size()];
}

bool counts_frames(int attribute) {
  const auto n = static_cast<std::size_t>(attribute);
  return n < rows().size() && (rows()[n].form == Form::of_frame || rows()[n].form == Form::time_step);
}

void add_traits_to(vtkDICOMItem& query) {
  for (const Row& row : rows()) {
    for (const auto& [tag, type] : row.elements) query.Set(tag, vtkDICOMValue(type));
    for (const OfMaker& of : row.of_makers) {
      for (int n = 0; n < of.count; ++n) {
        const vtkDICOMTag tag(of.group, static_cast<unsigned short>(of.element + n));
        query.Set(query.ResolvePrivateTagForWriting(tag, of.creator), vtkDICOMValue(of.type));
      }
    }
  }
  query.Set(DC::DimensionIndexSequence, vtkDICOMValue(VR::SQ));
  query.Set(DC::SliceVector, vtkDICOMValue(VR::US));
}

std::vector<Trait> traits_of(vtkDICOMMetaData& headers, int file, int frame, int frames) {
  static const vtkDICOMTagPath gradient(DC::MRDiffusionSequence, 0, DC::DiffusionGradientDirectionSequence, 0,
                                        DC::DiffusionGradientOrientation);
  std::vector<Trait> traits;
  std::set<unsigned> known;
  for (std::size_t r = 0; r < rows().size(); ++r) {
    const Row& row = rows()[r];
    const std::size_t before = traits.size();
    for (const auto& [tag, type] : row.elements) {
      const vtkDICOMValue* value = &headers.Get(file, frame, tag);
      if (row.form == Form::direction && !value->IsValid()) value = &headers.Get(file, frame, gradient);
      if (!value->IsValid()) continue;
      Trait trait = trait_of(row, *value, frame, frames);
      if (trait.numbers.empty() && trait.words.empty()) continue;
      trait.attribute = static_cast<int>(r);
      traits.push_back(std::move(trait));
      known.insert(number_of(vtkDICOMTag(tag)));
      break;
    }
    if (traits.size() > before || row.of_makers.empty()) continue;
    Trait trait = trait_of_maker(row, headers, file);
    if (trait.numbers.empty() && trait.words.empty()) continue;
    trait.attribute = static_cast<int>(r);
    traits.push_back(std::move(trait));
  }
  add_dimensions(headers, file, frame, known, traits);
  return traits;
}

std::vector<std::string> rest_of(vtkDICOMMetaData& headers, int file, int frame) {
  std::vector<std::string> rest;
  const vtkDICOMValue& groups = headers.Get(file, DC::PerFrameFunctionalGroupsSequence);
  if (static_cast<std::size_t>(frame) < groups.GetNumberOfValues() && groups.GetSequenceData() != nullptr) {
    add_rest(groups.GetSequenceData()[frame], rest);
  }
  return rest;
}

}  // namespace palpa::reader
