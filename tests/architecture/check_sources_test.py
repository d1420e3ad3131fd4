#!/usr/bin/env python3
"""Each check finds a planted violation."""

import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from check_pages import anchors_of, broken_links, missing_tests, too_long, unknown_names
from check_sources import arrows_of, code_of, functions_of, types_of, unitless_numbers, wrong_includes
from exceptions import words

page = """# Design
a ◄ nowhere
## 3. Layers and folders
solver ◄ field ◄ mode          words about ◄ arrows
solver ◄ device
mode, device ◄ loop
field ◄ file ◄ reader
field ◄ vtk
## 4. Else
x ◄ y
"""


class Arrows(unittest.TestCase):
    arrows = arrows_of(page)

    def wrong(self, path, text):
        return [what for _, what in wrong_includes(self.arrows, path, text)]

    def test_are_read_from_the_section_on_layers_and_followed_to_their_end(self):
        self.assertEqual(len(self.arrows), 8)
        self.assertEqual(self.arrows["solver"], {"solver"})
        self.assertEqual(self.arrows["mode"], {"solver", "field", "mode"})
        self.assertEqual(self.arrows["loop"], {"solver", "device", "field", "loop", "mode"})
        self.assertEqual(self.arrows["file"], {"solver", "field", "file"})

    def test_includes_along_them_are_allowed(self):
        for path, text in (("palpa/mode/a.h", '#include "palpa/field/grid.h"\n#include <vector>\n'),
                           ("palpa/field/a.cpp", '#include "palpa/version.h"'),
                           ("palpa/palpa.h", '#include "palpa/loop/loop.h"'),
                           ("reader/vtk.cpp", "#include <vtkImageData.h>\n#include <itkImage.h>"),
                           ("explorer/a.h", "#include <QWidget>\n#include <vtkProp.h>"),
                           ("palpa/vtk/a.h", "#include <vtkImageData.h>"),
                           ("palpa/mode/a.cpp", "#include <toml++/toml.h>"),
                           ("palpa/mode/a.h", "#include <queue>\n#include <sys/types.h>"),
                           ("reader/a.cpp", '#include "palpa/file/protocol.h"')):
            self.assertEqual(self.wrong(path, text), [], path)

    def test_others_are_seen(self):
        for path, text in (("palpa/field/a.h", '#pragma once\n #  include "palpa/mode/mode.h"'),
                           ("palpa/field/a.cpp", "#include <palpa/device/hand.h>"),
                           ("palpa/field/a.cpp", '#include "palpa/palpa.h"'),
                           ("palpa/field/a.cpp", '#include "grid.h"'),
                           ("palpa/field/a.cpp", '#include "../mode/mode.h"'),
                           ("palpa/new/a.cpp", ""),
                           ("palpa/file/a.cpp", "#include <vtkImageData.h>"),
                           ("app/a.cpp", "#include <itkImage.h>"),
                           ("explorer/a.cpp", "#include <itkImage.h>"),
                           ("palpa/vtk/a.h", "#include <itkImage.h>"),
                           ("app/a.cpp", "#include <QWidget>"),
                           ("palpa/mode/a.h", "#include <toml++/toml.h>"),
                           ("palpa/solver/a.cpp", "#include <fmt/format.h>"),
                           ("reader/a.cpp", '#include "palpa/file/read_volume.h"'),
                           ("reader/a.cpp", '#include "palpa/mode/mode.h"')):
            self.assertEqual(len(self.wrong(path, text)), 1, (path, text))


class Units(unittest.TestCase):
    def test_a_number_without_one_is_seen(self):
        for text, names in (
                ("struct A { double length; double width_m; };", ["length"]),
                ("struct A { double a = 0.0, b_m = 1, c{2}; std::optional<double> d; };", ["a", "c", "d"]),
                ("namespace n { Vec3 place(const Vec3& from, double by_m); }", ["place", "from"]),
                ("class A { double hidden; public: A(float given); private: double hidden_too; };", ["given"]),
                ("class A { public: void f(B b = {}, double x = {}) { double local; } double y; };", ["x", "y"]),
                ("class A { class B { double z; }; public: double y; };", ["y"]),
                ("template <class T> struct A { std::vector<T> t{1, 2}; std::span<const double> w; };", ["w"]),
                ("struct A {\n  double share;  ///< of all\n};", ["share"]),
                ("struct A {\n  double share;  ///< [0, 1]\n};", ["share"]),
                ("struct A {\n  double a;  ///< [1]\n  double b;\n};", ["b"]),
                ("/// Stretched [1].\nvoid stretch(double f);", ["f"]),
                ("struct A { double position, stiffness_per, drag_ns, item_mass, m_x, strength_n_; };",
                 ["position", "stiffness_per", "drag_ns", "item_mass", "m_x", "strength_n_"])):
            self.assertEqual([name for _, name in unitless_numbers(text)], names, text)
        self.assertEqual(unitless_numbers("\n\nstruct A {\n  double length;\n};"), [(4, "length")])

    def test_the_end_of_a_name_or_a_comment_says_it(self):
        for text in ("struct A { double position_m, stiffness_n_per_m, damping_n_s_per_m, per_s, tick_us_p99, force_max_n; };",
                     "struct A {\n  double share;  ///< [1] of all\n  Vec3 slope;  ///< [unit/m]\n};",
                     "struct A {\n  double value;  ///< in the field's own unit\n};",
                     "constexpr double rest =\n    1e-4;  ///< [1] of the spacing\n",
                     "/// Share [1] of all.\ndouble share();",
                     "/// \\param f  [1] factor\nvoid stretch(double f);",
                     "/// Stretched by `f`\n/// [1].\nvoid stretch(double f);"):
            self.assertEqual(unitless_numbers(text), [], text)

    def test_what_is_not_public_needs_none(self):
        for text in ("namespace palpa::detail { double x(double y); }",
                     "namespace palpa { namespace detail { struct A { double b; }; } }",
                     '// double a;\n/* double b; */\n#define C double c;\nconst char* d = "double e;";',
                     "virtual void number(const Info&, double&) {}\nusing F = std::function<void(double)>;"):
            self.assertEqual(unitless_numbers(text), [], text)


source = """namespace n {
struct A {
  int a() const {
    return 1;
  }
  double b = f({1.0});
  enum class C { d, e };
 private:
  std::vector<int> g{1, 2};
};
template <class T>
A::A(int x)
    : x_{x}, y_(x) {
  const auto inner = [&](int y) { return y; };
  if (x > 0) { inner('"'); }
}
constexpr int table[] = {f(1), 2};
namespace detail { class B final : public A {}; }
}  // namespace n
"""


class Sources(unittest.TestCase):
    def test_functions_and_types_are_found(self):
        self.assertEqual(functions_of(source), [("a", 3, 3), ("A", 11, 6)])
        self.assertEqual(types_of(source), ["A", "B"])

    def test_words_are_seen(self):
        for pattern, text, found in (
                (words[0][1], "std::ifstream in(path); int d = ::open(p, O_RDONLY); fs::rename(a, b); QFile f(n); return ::open(p);",
                 ["ifstream", "::open", "fs::rename", "QFile", "::open"]),
                (words[0][1], "// fopen(\nvoid A::open() { link->open(); reader.open(x); backend::open(s); }\n#include <fstream>", []),
                (words[1][1], 'std::snprintf(t, 9, "%g", x); double y = std::stod(t); // strtod', ["snprintf", "stod"]),
                (words[1][1], 'std::from_chars(a, b, x); detail::text("%g", x); std::printf("x");', []),
                (words[2][1], 'std::printf("x"); fmt::print("x"); std::cerr << "x"; print("x");', ["printf", "fmt::print", "cerr"])):
            self.assertEqual([each[0] for each in re.finditer(pattern, code_of(text))], found, text)


class Pages(unittest.TestCase):
    def test_anchors_are_those_of_headings(self):
        self.assertEqual(anchors_of("# VTK's own formats\n## 2. Words\ntext # no\n### `[time]`"), ["vtks-own-formats", "2-words", "time"])

    def test_links_that_lead_nowhere_are_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.md"
            file.write_text("# Part\n")
            text = "# Here\n[a](a.md) [b](b.md#part)\n[c](https://c.org) [d](#here) [e](#there) [f](a.md#part) [g](a.md#no)"
            page = file.with_name("page.md")
            page.write_text(text)
            self.assertEqual([line for line, _ in broken_links(page, text)], [2, 3, 3])

    def test_a_test_that_is_not_there_is_seen(self):
        text = "[`A.IsThere`](a.cpp), [`A.Too`](a.cpp), [`A.IsNot`](a.cpp), [`A.Is`](a.cpp), [`test_it`](a.py), [`test_i`](a.py)"
        of = {"a.cpp": "TEST(A, IsThere) {\nTEST_F(A, Too) {", "a.py": "def test_it(x):"}.get
        self.assertEqual(list(missing_tests(text, of)), ["A.IsNot", "A.Is", "test_i"])

    def test_long_cells_and_long_paragraphs_are_seen(self):
        words, links = "word " * 101, "[a](b) " * 11
        for text, count in ((f"| {words}| b |", 1), (f"| a | {links}|", 1), (words + links, 0), (3 * words, 1), (f"```\n{3 * words}\n```", 0)):
            self.assertEqual(len(list(too_long(text))), count, text)

    def test_new_names_that_are_not_there(self):
        sources = {"solver/law.h", "law", "Law", "set_law", "hand-place"}
        text = ("| `core/old.h`, `gone` | `<palpa/solver/law.h>`, `set_law(Law)` and words |\n|---|---|\n"
                "| `--fit` | `--hand-place`, `core/law.h` | `x.h` |\n| `a` | `Low` |\n")
        self.assertEqual([*unknown_names(text, sources)], [(3, "core/law.h"), (4, "Low")])


if __name__ == "__main__":
    unittest.main()
