#include "explorer/parameter_rows.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace palpa::explorer {
namespace {

constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();

/// Reads all rows, sets one of them, or appends to a list.
class Walk : public ParameterVisitor {
 public:
  std::vector<ParameterRow> rows;
  std::vector<ParameterListSize> lists;
  std::size_t set = nowhere;
  const ParameterRow::Value* value = nullptr;
  std::string append;  ///< name of the list to append to

  void number(const ParameterInfo& info, double& member) override { row(info, member); }
  void optional_number(const ParameterInfo& info, std::optional<double>& member) override { row(info, member); }
  void flag(const ParameterInfo& info, bool& member) override { row(info, member); }
  void text(const ParameterInfo& info, std::string& member) override { row(info, member); }
  void choice(const ParameterInfo& info, int& member) override {
    ParameterRow::Choice choice{member};
    row(info, choice);
    member = choice.index;
  }
  void field(const ParameterInfo& info, FieldRef& member) override { row(info, member); }
  void strength(const ParameterInfo& info, Strength& member) override { row(info, member); }
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& member) override { row(info, member); }
  void numbers(const ParameterInfo& info, std::vector<double>& member) override { row(info, member); }
  void list(const ParameterInfo& info, ParameterList& items) override {
    if (append == info.name) {
      items.append();
      append.clear();
    }
    lists.push_back({std::string(info.name), items.size()});
    for (std::size_t i = 0; i < items.size(); ++i) {
      const std::string before = std::exchange(group_, std::string(info.name) + " " + std::to_string(i + 1));
      items.visit(i, *this);
      group_ = before;
    }
  }

 private:
  template <class T>
  void row(const ParameterInfo& info, T& member) {
    if (rows.size() == set && value) {
      if (const T* given = std::get_if<T>(value)) member = *given;
    }
    ParameterRow& added = rows.emplace_back(ParameterRow{.info = info, .group = group_, .value = member});
    added.choices.assign(info.choices.begin(), info.choices.end());
    added.info.choices = {};
  }
  std::string group_;
};

}  // namespace

std::vector<ParameterRow> rows_of(const Visit& part) {
  Walk walk;
  part(walk);
  return std::move(walk.rows);
}

void set_row(const Visit& part, std::size_t row, const ParameterRow::Value& value) {
  Walk walk;
  walk.set = row;
  walk.value = &value;
  part(walk);
}

std::vector<ParameterListSize> lists_of(const Visit& part) {
  Walk walk;
  part(walk);
  return std::move(walk.lists);
}

void append_to(const Visit& part, const std::string& list) {
  Walk walk;
  walk.append = list;
  part(walk);
}

bool is_basic(const std::vector<ParameterRow>& rows, std::size_t row) {
  const ParameterRow& one = rows[row];
  const bool has_list = std::any_of(rows.begin(), rows.end(), [](const ParameterRow& other) { return !other.group.empty(); });
  if (one.info.kind == ParameterKind::level || std::holds_alternative<FieldRef>(one.value)) return true;
  if (one.group.empty() && has_list) return false;
  return one.info.name == "strength_n" || (one.group.empty() && one.info.name == "drag_ns_per_m");
}

void scale_strengths(const Visit& part, double factor) {
  const std::vector<ParameterRow> rows = rows_of(part);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (const auto* strength = std::get_if<Strength>(&rows[row].value)) {
      Strength scaled(factor * strength->constant_n);
      if (!strength->is_constant()) {
        std::vector<TransferFunction::Point> points = strength->curve.points();
        for (TransferFunction::Point& point : points) point.result *= factor;
        scaled = Strength(strength->of, TransferFunction(std::move(points), factor * strength->curve.outside()));
      }
      set_row(part, row, scaled);
    } else if (const auto* number = std::get_if<double>(&rows[row].value); number && rows[row].info.name == "drag_ns_per_m") {
      set_row(part, row, factor * *number);
    }
  }
}

std::string words_of_parameter(std::string_view parameter) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 7> known{
      {{"friction_n", "dry friction"},
       {"friction_ns_per_m", "viscous friction"},
       {"friction_coefficient", "Coulomb friction"},
       {"parts", "pieces"},
       {"strength_n", "how firm"},
       {"value", "where"},
       {"show", "shown as"}}};
  for (const auto& [name, words] : known)
    if (parameter == name) return std::string(words);
  return named_unit(parameter).name;
}

std::string words_of_choice(std::string_view parameter, const std::string& choice) {
  if (parameter == "solid") return choice == "high" ? "where the value is above" : "where the value is below";
  if (parameter == "parts") return choice == "large" ? "large ones" : choice;
  return choice;
}

NamedUnit named_unit(std::string_view parameter) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 15> units{{{"_nms_per_rad", "N·m·s/rad"},
                                                                                        {"_nm", "N·m"},
                                                                                        {"_rad", "rad"},
                                                                                        {"_ns_per_m", "N·s/m"},
                                                                                        {"_n_per_m", "N/m"},
                                                                                        {"_n_per_s", "N/s"},
                                                                                        {"_m_per_s", "m/s"},
                                                                                        {"_per_m", "1/m"},
                                                                                        {"_deg", "°"},
                                                                                        {"_hz", "Hz"},
                                                                                        {"_ms", "ms"},
                                                                                        {"_n", "N"},
                                                                                        {"_s", "s"},
                                                                                        {"_m", "m"},
                                                                                        {"_j", "J"}}};
  NamedUnit named{std::string(parameter), ""};
  for (const auto& [ending, unit] : units) {
    if (!parameter.ends_with(ending)) continue;
    named = {std::string(parameter.substr(0, parameter.size() - ending.size())), std::string(unit)};
    break;
  }
  std::replace(named.name.begin(), named.name.end(), '_', ' ');
  return named;
}

}  // namespace palpa::explorer
