#include "palpa/data/length_unit.h"

#include <gtest/gtest.h>

#include <cctype>
#include <string>

namespace palpa {
namespace length_unit_test {

/// [m] 0: no unit of length.
double metres(std::string_view text) {
  const auto unit = detail::length_unit(text);
  return unit ? unit->metres : 0.0;
}

std::string with(std::string text, int (*change)(int)) {
  for (char& c : text) c = static_cast<char>(change(static_cast<unsigned char>(c)));
  return text;
}

/// SI's prefixes in both spellings, singular and plural, small, capital and mixed letters, joined or not.
TEST(LengthUnit, EveryPrefixTimesTheMetreInEverySpelling) {
  const std::pair<std::string, int> prefixes[] = {{"", 0},      {"deci", -1},  {"centi", -2}, {"milli", -3}, {"micro", -6},
                                                  {"nano", -9}, {"pico", -12}, {"kilo", 3},   {"hecto", 2}};
  for (const auto& [prefix, power] : prefixes) {
    for (const std::string stem : {"metre", "meter", "metres", "meters", "metre(s)"}) {
      const std::string word = prefix + stem;
      const double expected = std::stod("1e" + std::to_string(power));
      std::string title = word;
      title[0] = static_cast<char>(std::toupper(title[0]));
      for (const std::string& text : {word, with(word, std::toupper), title, " " + word + " ", "[" + word + "]",
                                      "'" + word + "'", prefix + " " + stem, word + "."})
        EXPECT_DOUBLE_EQ(metres(text), expected) << text;
    }
  }
}

TEST(LengthUnit, SymbolsOfEveryAlphabetAndOtherSystems) {
  for (const char* micron :
       {"um", "UM", "\u00b5m", "\u03bcm", "\xb5m", "Micron", "microns", "micrometers", "micrometre", "mikrometer"})
    EXPECT_DOUBLE_EQ(metres(micron), 1e-6) << micron;
  for (const char* angstrom : {"angstrom", "Angstroms", "\u00c5", "\u212b", "A\u030a", "\u00c5ngstr\u00f6m", "A"})
    EXPECT_DOUBLE_EQ(metres(angstrom), 1e-10) << angstrom;
  for (const char* inch : {"in", "inch", "Inches", "IN."}) EXPECT_DOUBLE_EQ(metres(inch), 0.0254) << inch;
  for (const char* foot : {"ft", "foot", "Feet"}) EXPECT_DOUBLE_EQ(metres(foot), 12 * 0.0254) << foot;
  EXPECT_DOUBLE_EQ(metres("yard"), 36 * 0.0254);
  EXPECT_DOUBLE_EQ(metres("miles"), 5280 * 12 * 0.0254);
  EXPECT_DOUBLE_EQ(metres("MM"), 1e-3);
  EXPECT_DOUBLE_EQ(metres("Cm"), 1e-2);
  EXPECT_DOUBLE_EQ(metres("KM"), 1e3);
}

TEST(LengthUnit, AFactorBeforeTheUnitMultipliesIt) {
  for (const char* text : {"1e-3 m", "0.001 m", "1E-3 metres", "10^-3 m", "0.1cm", "1e-3*m", "1000 um", "10**-3 m"})
    EXPECT_NEAR(metres(text), 1e-3, 1e-18) << text;
  for (const char* text : {"0 m", "-1 mm", "nan mm", "inf m", "- m", "1e999 m", "1e-400 m"})
    EXPECT_EQ(metres(text), 0.0) << text;
}

TEST(LengthUnit, NoOtherWordIsALength) {
  for (const char* text :
       {"",    "?",   "furlong", "pixel", "voxels", "ms", "s",       "kg",     "degrees",      "degrees_east", "K",
        "m/s", "1/m", "m2",      "mm^2",  "mmHg",   "1",  "unknown", "metric", "millimeterss", "mmm"})
    EXPECT_EQ(metres(text), 0.0) << text;
  // An ambiguous spelling of two units, 10^9 apart.
  for (const char* text : {"Mm", "Pm", "NM"}) EXPECT_EQ(metres(text), 0.0) << text;
}

TEST(LengthUnit, OnlyWordsForNoneLeaveItOpen) {
  for (const char* text : {"", "?", "???", "unknown", "None", "n/a", " "})
    EXPECT_TRUE(detail::leaves_length_unit_open(text)) << text;
  for (const char* text : {"furlong", "pixel", "Mm", "mm", "code 5 of xyzt_units"})
    EXPECT_FALSE(detail::leaves_length_unit_open(text)) << text;
}

TEST(LengthUnit, NamesAreFoundAgain) {
  for (const std::string_view proposed : detail::proposed_length_units) {
    const auto unit = detail::length_unit(proposed);
    ASSERT_TRUE(unit) << proposed;
    EXPECT_EQ(unit->name, proposed);
  }
  EXPECT_EQ(detail::length_unit("Millimetres")->name, "mm");
  const std::string odd = detail::length_unit("2.5 mm")->name;
  EXPECT_DOUBLE_EQ(metres(odd), 2.5e-3) << odd;
}

}  // namespace length_unit_test
}  // namespace palpa
