// The page around a report: contents list, style, scripts, and the promise that nothing else is loaded.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace palpa::detail {

/// A page of sections, complete in itself. What it may run is named by its checksum, so that nothing that others wrote can run,
/// were it to slip in.
class Page {
 public:
  /// \param title  a text
  explicit Page(std::string title) : title_(std::move(title)) {}

  /// Markup under the title, before the first section.
  void begin_with(const std::string& markup) { head_ += markup; }
  /// A section: a line of the contents list, a heading, and markup.
  /// \param id  letters
  void section(const std::string& id, const std::string& heading, const std::string& markup);
  /// Markup after the last section.
  void end_with(const std::string& markup) { tail_ += markup; }
  /// JSON for the scripts, which find it by its id.
  void data(const std::string& id, std::string json);
  /// Runs the resource called `name` at the end of the page, in the order of these calls.
  void script(std::string name) { scripts_.push_back(std::move(name)); }

  std::string html() const;

 private:
  std::string title_, head_, body_, tail_, data_;
  std::vector<std::pair<std::string, std::string>> contents_;  // id, heading
  std::vector<std::string> scripts_;
};

}  // namespace palpa::detail
