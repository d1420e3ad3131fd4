#include "messages.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <iostream>
#include <sstream>
#include <utility>

#include "library_words.h"
#include "palpa/base/sanitized.h"

namespace palpa::reader {
namespace {

using detail::shortened;

std::vector<std::string> errors;
std::vector<std::string> warnings;
std::ostringstream streams;  // MetaIO prints its errors to std::cerr, some to std::cout

/// Sentence of `ERROR: In file.cxx, line 12\nvtkClass (0x55…): the sentence\n`, on one line.
std::string sentence_in(std::string text) {
  for (const char* start : {"ERROR: In ", "Warning: In ", "Generic Warning: In "}) {
    if (text.rfind(start, 0) == 0 && text.find('\n') != std::string::npos) text.erase(0, text.find('\n') + 1);
  }
  if (const std::size_t who = text.find(" (0x"), end = text.find("): "); who < end && end != std::string::npos)
    text.erase(0, end + 3);
  std::istringstream words(text);
  std::string sentence;
  for (std::string word; words >> word;) sentence += (sentence.empty() ? "" : " ") + word;
  return sentence.substr(0, sentence.find_last_not_of(".!") + 1);
}

class Messages : public vtkOutputWindow {
 public:
  static Messages* New();
  vtkTypeMacro(Messages, vtkOutputWindow);
  void DisplayText(const char*) override {}
  void DisplayDebugText(const char*) override {}
  void DisplayErrorText(const char* text) override { errors.push_back(sentence_in(text)); }
  void DisplayWarningText(const char* text) override { add_warning(sentence_in(text)); }
  void DisplayGenericWarningText(const char* text) override { add_warning(sentence_in(text)); }

 private:
  /// Legacy readers report missing values only as a warning.
  static void add_warning(std::string sentence) {
    (sentence.rfind("Error", 0) == 0 ? errors : warnings).push_back(std::move(sentence));
  }
};
vtkStandardNewMacro(Messages);

}  // namespace

void catch_library_messages() {
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  vtkOutputWindow::SetInstance(vtkSmartPointer<Messages>::New());
  std::cerr.rdbuf(streams.rdbuf());
  std::cout.rdbuf(streams.rdbuf());
}

bool library_complained() noexcept { return !errors.empty(); }

std::string take_library_error() {
  std::string first = errors.empty() ? sentence_in(streams.str()) : errors.front();
  errors.clear();
  streams.str({});
  // Error of VTK's pipeline without information on the file.
  if (first.find("returned failure for request") != std::string::npos) first = "its library says no more";
  return shortened(known_words(first), 300);
}

std::vector<std::string> take_library_warnings() {
  std::vector<std::string> taken = std::exchange(warnings, {});
  for (std::string& warning : taken) warning = shortened(known_words(warning), 300);
  return taken;
}

}  // namespace palpa::reader
