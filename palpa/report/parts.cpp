#include "palpa/report/parts.h"

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "palpa/mode/plugin.h"
#include "palpa/report/html.h"
#include "palpa/study/recorded_scene.h"
#include "palpa/view/plot.h"

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;

constexpr const char* software = R"(<details>
<summary>Software in this page</summary>
<p>three.js r111, copyright 2010–2019 three.js authors; dygraphs 2.2.1, copyright 2006–2023 Dan Vanderkam and others.</p>
<p>Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation files (the
&quot;Software&quot;), to deal in the Software without restriction, including without limitation the rights to use, copy, modify, merge, publish,
distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is furnished to do so, subject
to the following conditions: The above copyright notice and this permission notice shall be included in all copies or substantial
portions of the Software. THE SOFTWARE IS PROVIDED &quot;AS IS&quot;, WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT
LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING
FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.</p>
</details>
)";

}  // namespace

Existing what_becomes_of(const fs::path& file, const ReportOptions& options) {
  if (options.replace) return Existing::replaced;
  const InputFile old(file);
  if (!old.is_open()) return Existing::refused;
  std::string begin(2000, '\0');
  begin.resize(old.read(0, begin.data(), begin.size()));
  if (!begin.empty() && begin.find("<meta name=\"generator\" content=\"palpa ") == std::string::npos)
    throw LoadError(file.string() +
                    ": is there already and is no report of palpa; choose another name, or have it replaced (--force)");
  return Existing::replaced;
}

void keep(const ReportOptions& options, const std::string& name, const std::string& bytes) {
  if (!options.pictures.empty())
    write_whole(options.pictures / name, bytes, options.replace ? Existing::replaced : Existing::refused);
}

std::string figure(const std::string& content, const std::string& caption) {
  return "<figure>\n<div class=\"card\">" + content + "</div>\n<figcaption>" + escaped(caption) + "</figcaption>\n</figure>\n";
}

std::string notice(const std::string& words) { return "<p class=\"notice\">" + escaped(words) + "</p>\n"; }

std::string plots_markup(const std::vector<TimePlot>& plots, bool has_moments, const ReportOptions& options) {
  std::string out =
      "<p class=\"live live-plots hint\">Drag over a stretch of time to see it larger in all plots, double click to see "
      "all of it again";
  out += has_moments ? "; click to look at that moment.</p>\n<div class=\"plots\">\n" : ".</p>\n<div class=\"plots\">\n";
  for (const TimePlot& one : plots) {
    std::string svg = svg_of(one.plot, 760, one.id == "time" ? 220 : 280, one.id + "-");
    keep(options, one.id + ".svg", svg);
    svg.insert(4, " role=\"img\" aria-label=\"" + escaped(one.label) + "\"");
    out += "<figure class=\"plot\">\n<h3 class=\"live live-plots\">" + escaped(one.plot.title) +
           "</h3>\n<div class=\"live live-plots readout\" id=\"values-" + one.id +
           "\"></div>\n<div class=\"live live-plots chart\" id=\"plot-" + one.id +
           "\"></div>\n<div class=\"still still-plots card\">" + svg + "</div>\n<figcaption>" + escaped(one.caption) +
           "</figcaption>\n</figure>\n";
  }
  return out + "</div>\n";
}

std::string software_markup() { return software; }

std::optional<LoadedScene> scene_of(const fs::path& trace, const Recorded& recorded, const ReportOptions& options,
                                    std::string& why_not) {
  try {
    if (options.plugins.empty() && !recorded.header.plugins.empty()) {
      throw LoadError((trace / "trace.toml").string() + ": was recorded with the plug-in " + recorded.header.plugins.front() +
                      "; name it with --plugin if you trust it");
    }
    return load_recorded_scene(trace, TraceReader(trace), options.data_folders, options.read, modes_with(options.plugins));
  } catch (const LoadError& error) {
    why_not = error.what();
    return {};
  }
}

}  // namespace palpa::detail
