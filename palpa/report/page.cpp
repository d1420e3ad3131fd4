#include "palpa/report/page.h"

#include <charconv>

#include "palpa/base/sanitized.h"
#include "palpa/report/html.h"
#include "palpa/report/resources.h"
#include "palpa/version.h"

namespace palpa::detail {
namespace {

/// Checksum in the form of a Content-Security-Policy.
std::string source_of(const Resource& script) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < script.sha256.size(); i += 2) {
    unsigned byte = 0;
    std::from_chars(script.sha256.data() + i, script.sha256.data() + i + 2, byte, 16);
    bytes += static_cast<char>(byte);
  }
  return " 'sha256-" + base64(bytes) + "'";
}

}  // namespace

void Page::section(const std::string& id, const std::string& heading, const std::string& markup) {
  contents_.emplace_back(id, heading);
  body_ += "<section id=\"" + id + "\">\n<h2>" + escaped(heading) + "</h2>\n" + markup + "</section>\n";
}

void Page::data(const std::string& id, std::string json) {
  // '<' occurs in JSON strings only; escaped, it cannot end the element.
  for (std::size_t at = json.find('<'); at != std::string::npos; at = json.find('<', at)) json.replace(at, 1, "\\u003c");
  for (std::size_t at = 0; at < json.size(); ++at) {
    if (const std::size_t length = steering_length(std::string_view(json).substr(at)); length > 0)
      json.replace(at, length, " ");
  }
  data_ += "<script type=\"application/json\" id=\"" + id + "\">" + json + "</script>\n";
}

std::string Page::html() const {
  std::string allowed;
  for (const std::string& name : scripts_) allowed += source_of(resource(name));
  std::string contents;
  for (const auto& [id, heading] : contents_) contents += "<li><a href=\"#" + id + "\">" + escaped(heading) + "</a></li>\n";
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src" +
      (allowed.empty() ? " 'none'" : allowed) +
      "; base-uri 'none'; form-action 'none'\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"palpa " +
      std::string(version) + "\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>" + escaped(title_) +
      " \u2013 Palpa</title>\n<style>" + std::string(resource("dygraph.min.css").text) +
      std::string(resource("report.css").text) +
      "</style>\n</head>\n<body>\n<nav aria-label=\"Contents\">\n<p class=\"brand\">Palpa</p>\n<ul>\n" + contents +
      "</ul>\n</nav>\n<main>\n<header>\n<h1>" + escaped(title_) + "</h1>\n" + head_ + "</header>\n" + body_ + tail_ +
      "</main>\n" + data_;
  for (const std::string& name : scripts_) out += "<script>" + std::string(resource(name).text) + "</script>\n";
  return out + "</body>\n</html>\n";
}

}  // namespace palpa::detail
