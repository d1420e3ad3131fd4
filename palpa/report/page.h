// HTML page around a report: contents list, style, scripts, and a policy that forbids loading anything else.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace palpa::detail {

/// Self-contained page of sections. Scripts are allowed by checksum only, so that injected scripts cannot run.
class Page {
 public:
  /// \param title  a text
  explicit Page(std::string title) : title_(std::move(title)) {}

  /// Markup between the title and the first section.
  void begin_with(const std::string& markup) { head_ += markup; }
  /// Section: entry of the contents list, heading, markup.
  /// \param id  letters
  void section(const std::string& id, const std::string& heading, const std::string& markup);
  /// Markup after the last section.
  void end_with(const std::string& markup) { tail_ += markup; }
  /// JSON for the scripts, under an id.
  void data(const std::string& id, std::string json);
  /// Runs resource `name` at the end of the page, in the order of these calls.
  void script(std::string name) { scripts_.push_back(std::move(name)); }

  std::string html() const;

 private:
  std::string title_, head_, body_, tail_, data_;
  std::vector<std::pair<std::string, std::string>> contents_;  // id, heading
  std::vector<std::string> scripts_;
};

}  // namespace palpa::detail
