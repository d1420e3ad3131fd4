// Damaged scenes, hands and traces for the program.
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <sstream>

#include "tests/fuzz/campaigns.h"
#include "tests/fuzz/program.h"
#include "tests/reader/damage.h"
#include "tests/report/markup.h"

namespace palpa::fuzz {
namespace {

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}
void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

// Unescaped in a page it would be part of the page's markup.
constexpr const char* foreign_markup = "</script><script>palpa_was_here()</script>";

const std::vector<std::string>& hostile_words() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> made{"0",
                                  "-1",
                                  "1e308",
                                  "-1e308",
                                  "nan",
                                  "inf",
                                  "-inf",
                                  "1e-320",
                                  "9223372036854775807",
                                  "-9223372036854775808",
                                  "18446744073709551616",
                                  "0x7fffffff",
                                  "1e15",
                                  "400",
                                  "1000",
                                  "true",
                                  "\"\"",
                                  "[]",
                                  "{}",
                                  "[[]]",
                                  "[nan, 0, 0]",
                                  "\"../../../../etc/passwd\"",
                                  "\"/dev/zero\"",
                                  "\"/dev/random\"",
                                  "\"/proc/self/mem\"",
                                  "\"pipe\"",
                                  "\".\"",
                                  "\"link\"",
                                  "\"head\"",
                                  "\"v\\u0000w\"",
                                  "\"\\u001b[31m\\u0007\"",
                                  "\"\\u202e\\u0085\"",
                                  "1979-05-27T07:32:00Z",
                                  "{a = \"\"\"b\"\"\"\", c = 1}",
                                  foreign_markup};
    made.push_back("\"" + std::string(100'000, 'a') + "\"");
    made.push_back(std::string(20'000, '[') + std::string(20'000, ']'));
    std::string deep = "{a = \"\"\"b\"\"\"\", c";
    for (int n = 0; n < 50'000; ++n) deep += ".c";
    made.push_back(deep + " = 1}");
    std::string long_list = "[";
    for (int n = 0; n < 20'000; ++n) long_list += "[" + std::to_string(n) + ", 1], ";
    made.push_back(long_list + "]");
    return made;
  }();
  return words;
}

const std::vector<std::string>& hostile_lines() {
  static const std::vector<std::string> lines{"frames = 1000",
                                              "sampled = 400",
                                              "sampled = 2000",
                                              "file = \"/dev/zero\"",
                                              "file = \"pipe\"",
                                              "file = \".\"",
                                              "analytic = \"beating_chamber\"",
                                              "[[mode]]",
                                              "[volume.head]",
                                              "[volume.\"a b\"]",
                                              "[coupling]",
                                              "[time]",
                                              "play = \"loop\"",
                                              "speed = 1e300",
                                              "needs = [\"x\"]",
                                              "palpa = 2",
                                              "[workspace]",
                                              "scale = 1e-300",
                                              "scale = 1e300",
                                              "[[mode.level]]",
                                              "[[view.layer]]",
                                              "enabled = false",
                                              "filter = \"cubic\"",
                                              "smoothing_m = 1e9",
                                              "smoothing_m = 1e-9",
                                              "poses = [{time_s = 0}, {time_s = 1e-300, translate_m = [1e300, 0, 0]}]",
                                              "[law]\nmethod = \"no-proxy\"",
                                              "a.b.c.d.e = 1",
                                              "\"\" = 1",
                                              "\xef\xbb\xbf",
                                              std::string("a\0b = 1", 7),
                                              "\x1b]0;title\x07",
                                              "# \xff\xfe"};
  return lines;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool is_of_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || std::string_view("._-+\"").find(c) != std::string_view::npos;
}

void change_word(Choices& choices, std::string& line, const std::string& by) {
  if (line.empty()) return;
  std::size_t at = static_cast<std::size_t>(choices.below(line.size()));
  // Most often the value, where typing errors are likely and which is computed with.
  if (const std::size_t equals = line.find("= "); equals != std::string::npos && !choices.one_in(4)) at = equals + 2;
  std::size_t begin = at, end = at;
  while (begin > 0 && is_of_word(line[begin - 1])) --begin;
  while (end < line.size() && is_of_word(line[end])) ++end;
  line.replace(begin, end - begin, by);
}

/// Text damaged as text: words and lines exchanged, removed, doubled and inserted; or as bytes.
std::string damaged_text(Choices& choices, const std::string& text, const std::vector<std::string>& others) {
  test::Damage damage([&](std::size_t n) { return static_cast<std::size_t>(choices.below(n)); });
  std::string result = text;
  for (std::uint64_t n = 1 + choices.below(3); n > 0; --n) {
    std::vector<std::string> lines = lines_of(result);
    if (lines.empty()) return result;
    const auto any_line = [&] { return lines.begin() + static_cast<std::ptrdiff_t>(choices.below(lines.size())); };
    switch (choices.below(8)) {
      case 0:
      case 1:
      case 2: change_word(choices, *any_line(), choices.one_of(hostile_words())); break;
      case 3: {
        const std::vector<std::string> foreign = lines_of(choices.one_of(others));
        const std::string& line = choices.one_of(foreign);
        change_word(choices, *any_line(), line.substr(std::min(line.find("= "), line.size() - 1) + 1));
        break;
      }
      case 4: lines.insert(any_line(), choices.one_of(hostile_lines())); break;
      case 5: lines.insert(any_line(), *any_line()); break;
      case 6: lines.erase(any_line()); break;
      default: result = damage.damaged(result); continue;
    }
    result.clear();
    for (const std::string& line : lines) result += line + "\n";
  }
  return result;
}

/// Text with one changed value (a quoted text, a cell of a row) in its unchanged context, so that the form is not refused.
std::string with_another_value(Choices& choices, const std::string& text) {
  static const std::vector<std::string> values{"0",
                                               "-1",
                                               "1e308",
                                               "1e-320",
                                               "nan",
                                               "-inf",
                                               "4294967295",
                                               foreign_markup,
                                               "<img src=x onerror=palpa_was_here()>",
                                               "--><!--",
                                               "]]>&amp;&#x202e;",
                                               "\u202e\u0085\u2028",
                                               "' onclick='palpa_was_here()",
                                               std::string(20'000, 'a'),
                                               ""};
  std::vector<std::string> lines = lines_of(text);
  const bool is_table = text.find('=') > text.find('\n');  // its first line names columns
  if (lines.size() < 2) return text;
  std::string& line = lines[1 + static_cast<std::size_t>(choices.below(lines.size() - 1))];
  std::size_t begin = 0, end = line.size();
  if (is_table) {
    const auto cells = static_cast<std::uint64_t>(std::count(line.begin(), line.end(), ',')) + 1;
    for (std::uint64_t n = choices.below(cells); n > 0; --n) begin = line.find(',', begin) + 1;
    end = std::min(line.find(',', begin), line.size());
  } else if (line.find('"') != line.rfind('"')) {
    begin = line.find('"') + 1, end = line.find('"', begin);
  } else {
    begin = std::min(line.find("= "), line.size() - 2) + 2;
  }
  if (begin > end) return text;
  line.replace(begin, end - begin, choices.one_of(values));
  std::string result;
  for (const std::string& each : lines) result += each + "\n";
  return result;
}

/// Files that a scene or a hand may name by mistake.
void put_traps(const fs::path& folder) {
  ::mkfifo((folder / "pipe").c_str(), 0600);
  fs::create_symlink("/dev/zero", folder / "link");
}

// ---- seeds ----

const std::string small_scene = R"toml(palpa = 1
title = "a head"
[coupling]
stiffness_n_per_m = 800
damping_ns_per_m = 0.3
max_force_n = 3.3
[time]
play = "hold"
[volume.head]
analytic = "head_phantom"
[volume.flow]
analytic = "burgers_vortex"
sampled = 16
pose = { translate_m = [0.0, 0.0, 0.0], scale = 2.0 }
[workspace]
fit = "head"
towards_user = "anterior"
up = "superior"
[[mode]]
name = "surface"
type = "surface_and_friction"
field = "head"
[[mode.level]]
name = "skin"
value = -300
strength_n = 0.8
friction_n = 0.1
[[mode]]
name = "rail"
type = "follow"
field = "flow"
strength_n = 0.4
[[mode]]
name = "tube"
type = "vortex_plane"
field = "flow"
strength_n = { of = "q(flow)", points = [[0.0, 0.0], [1.0, 0.5]] }
)toml";

std::string small_hand(int columns) {
  std::ostringstream text;
  const char* const headers[] = {"t_s,x_m,y_m,z_m\n", "t_s,probe_x_m,probe_y_m,probe_z_m,buttons\n",
                                 "Time,Cursor Position X,Cursor Position Y,Cursor Position Z\n", "x,y,z\n"};
  text << headers[columns];
  for (int n = 0; n < 60; ++n) {
    if (columns < 3) text << 0.005 * n << ',';
    text << 0.0005 * n << ",0.01," << 0.09 - 0.0015 * n;
    text << (columns == 1 ? ",0\n" : "\n");
  }
  return text.str();
}

/// The shipped scenes without data, on coarse grids, and small scenes.
std::vector<std::string> scenes() {
  std::vector<std::string> all{small_scene};
  for (const auto& entry : fs::directory_iterator(PALPA_SCENES_FOLDER)) {
    if (!entry.path().stem().string().ends_with("_phantom")) continue;
    std::string text = content(entry.path());
    const std::string key = "sampled = ";
    for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
      const std::size_t begin = at + key.size();
      text.replace(begin, text.find_first_not_of("0123456789", begin) - begin, "16");
    }
    all.push_back(text);
  }
  std::sort(all.begin() + 1, all.end());
  return all;
}

Start start_of(const fs::path& folder, std::vector<std::string> arguments) {
  return {.program = programs_folder() / "palpa",
          .arguments = std::move(arguments),
          .folder = folder,
          .patience_s = 60.0 * slowness};
}

/// A run with little memory, as on a small machine: a text may request all memory.
Ended ended_in_little_memory(Start start) {
  start.before = [] {
    const rlimit little{1'500'000'000, 1'500'000'000};
    ::setrlimit(is_sanitized ? RLIMIT_RSS : RLIMIT_AS, &little);  // a sanitizer has 20 TB of addresses of its own
  };
  return ended(start);
}

std::string broken_by_text(const Ended& run, bool may_answer_no = false) {
  if (std::string broken = broken_by_run(run, may_answer_no); !broken.empty()) return broken;
  if (run.err.find("memory: not enough") != std::string::npos)
    return "what a text asks for too much is named: " + run.err.substr(0, 300);
  return {};
}

std::string broken_by_trace(const fs::path& trace, const Ended& run) {
  const bool is_complete = content(trace / "trace.toml").find("complete = true") != std::string::npos;
  if (run.code == 0 && !is_complete) return "a run that ends well leaves a whole trace";
  if (run.code == 2 && is_complete) return "a run that failed leaves nothing that looks complete: " + run.err.substr(0, 300);
  return {};
}

Ended run_scene(const fs::path& folder, const std::string& scene, const std::string& hand, bool laid) {
  put_traps(folder);
  write(folder / "scene.toml", scene);
  write(folder / "hand.csv", hand);
  std::vector<std::string> arguments{"run",          "scene.toml", "--hand", "hand.csv", "--hand-fit", laid ? "on" : "off",
                                     "--duration-s", "0.2",        "--out",  "trace"};
  if (hand.starts_with("x,")) arguments.insert(arguments.end(), {"--hand-rate-hz", "200"});  // without times of its own
  return ended_in_little_memory(start_of(folder, arguments));
}

Tried felt(const fs::path& folder, const std::string& scene, const std::string& hand, bool laid) {
  const Ended run = run_scene(folder, scene, hand, laid);
  Tried result{.broken = broken_by_text(run), .slowest_s = run.spent_s, .refused = run.code == 2};
  if (result.broken.empty()) result.broken = broken_by_trace(folder / "trace", run);
  return result;
}

/// Undamaged all must run, else nothing is tested.
void expect_felt(const fs::path& folder, const std::string& scene, const std::string& hand) {
  fs::create_directory(folder);
  const Ended run = run_scene(folder, scene, hand, false);
  if (run.code != 0) throw std::runtime_error("what is to be damaged cannot be felt: " + run.err);
}

Attempt begin_scenes(const fs::path& shared) {
  const std::vector<std::string> all = scenes();
  const std::string hand = small_hand(0);
  for (std::size_t n = 0; n < all.size(); ++n) expect_felt(shared / std::to_string(n), all[n], hand);
  return [=](Choices& choices, const fs::path& folder) {
    return felt(folder, damaged_text(choices, choices.one_of(all), all), hand, false);
  };
}

Attempt begin_hands(const fs::path& shared) {
  std::vector<std::string> all;
  for (int columns = 0; columns < 4; ++columns) {
    all.push_back(small_hand(columns));
    expect_felt(shared / std::to_string(columns), small_scene, all.back());
  }
  return [=](Choices& choices, const fs::path& folder) {
    return felt(folder, small_scene, damaged_text(choices, choices.one_of(all), all), choices.one_in(4));
  };
}

/// A trace with all its files; damage is done to a copy.
class Recorded {
 public:
  explicit Recorded(const fs::path& folder) : trace_(folder / "trace") {
    write(folder / "scene.toml", small_scene);
    write(folder / "hand.csv", small_hand(0));
    const Ended run = ended(start_of(folder, {"run", "scene.toml", "--hand", "hand.csv", "--hand-fit", "off", "--duration-s",
                                              "0.2", "--primitives", "--out", "trace"}));
    if (run.code != 0) throw std::runtime_error("no trace could be recorded: " + run.err);
    for (const auto& entry : fs::directory_iterator(trace_)) {
      files_.push_back(entry.path().filename());
      texts_.push_back(content(entry.path()));
    }
    std::sort(files_.begin(), files_.end());
  }
  void put_damaged(Choices& choices, const fs::path& to) const {
    fs::copy(trace_, to);
    put_traps(to);
    constexpr std::array often{"trace.toml", "scene.toml", "ticks.csv", "events.csv"};
    const fs::path file = to / (choices.one_in(3) ? choices.one_of(files_) : fs::path(choices.one_of(often)));
    const std::string bytes = content(file);
    fs::remove(file);
    if (choices.one_in(2)) {
      write(file, with_another_value(choices, bytes));
    } else if (choices.one_in(8)) {
      test::Damage damage([&](std::size_t n) { return static_cast<std::size_t>(choices.below(n)); });
      damage.put(file, bytes);
    } else {
      write(file, damaged_text(choices, bytes, texts_));
    }
  }

 private:
  fs::path trace_;
  std::vector<fs::path> files_;
  std::vector<std::string> texts_;
};

Attempt begin_traces(const fs::path& shared) {
  return [recorded = Recorded(shared)](Choices& choices, const fs::path& folder) {
    recorded.put_damaged(choices, folder / "trace");
    const Ended run = ended_in_little_memory(start_of(folder, {"replay", "trace"}));
    return Tried{.broken = broken_by_text(run, true), .slowest_s = run.spent_s, .refused = run.code == 2};
  };
}

Attempt begin_reports(const fs::path& shared) {
  return [recorded = Recorded(shared)](Choices& choices, const fs::path& folder) {
    recorded.put_damaged(choices, folder / "trace");
    const Ended run = ended(start_of(folder, {"report", "trace", "--out", "page.html"}));
    Tried result{.broken = broken_by_run(run), .slowest_s = run.spent_s, .refused = run.code == 2};
    if (!result.broken.empty()) return result;
    const std::string page = content(folder / "page.html");
    if (run.code == 0 && page.find("</html>") == std::string::npos) result.broken = "a report that was written is whole";
    if (run.code == 0 && result.broken.empty()) {
      if (const std::string wrong = markup_error(page, true); !wrong.empty())
        result.broken = "a report is the markup that it was made as: " + wrong;
    }
    if (run.code != 0 && fs::exists(folder / "page.html")) result.broken = "a report that failed leaves nothing";
    if (page.find(foreign_markup) != std::string::npos) result.broken = "what a trace says is words, never part of the page";
    return result;
  };
}

std::string missing() { return missing_program("palpa"); }
std::string missing_pictures() {
  if (const std::string why = missing(); !why.empty()) return why;
  return PALPA_HAS_REPORTS ? "" : "reports are not built";
}

}  // namespace

void add_texts(std::vector<Campaign>& to) {
  to.push_back({.name = "scene",
                .of = "scenes",
                .long_tries = 100'000,
                .begin = begin_scenes,
                .patience_s = 90.0 * slowness,
                .missing = missing});
  to.push_back({.name = "hand",
                .of = "hands",
                .long_tries = 100'000,
                .begin = begin_hands,
                .patience_s = 90.0 * slowness,
                .missing = missing});
  to.push_back({.name = "trace",
                .of = "traces",
                .long_tries = 100'000,
                .begin = begin_traces,
                .patience_s = 90.0 * slowness,
                .missing = missing});
  to.push_back({.name = "report",
                .of = "reports",
                .long_tries = 2'000,
                .begin = begin_reports,
                .patience_s = 90.0 * slowness,
                .missing = missing_pictures});
}

}  // namespace palpa::fuzz
