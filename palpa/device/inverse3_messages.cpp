#include "palpa/device/inverse3_messages.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

namespace palpa::inverse3 {

namespace {

using nlohmann::json;

// The service's messages have eight levels. More: malicious nesting costs time; fewer: a later service's additions may be
// refused.
constexpr int deepest_level = 24;
// Entries per list. More: a list of another kind passes; fewer: a hall full of devices is refused.
constexpr std::size_t most_devices = 64;
// Beyond every Inverse3, however mounted. Larger: invalid positions pass; smaller: a service that scales the workspace may be
// refused.
constexpr double furthest_m = 10.0;
constexpr double fastest_m_per_s = 1000.0;
constexpr double strongest_n = 1000.0;
// First version documented with `vector`.
constexpr std::pair first_with_vector{3, 5};

/// Whether lists and objects are nested no deeper than `deepest_level`, as far as the text is JSON.
bool is_shallow(std::string_view text) noexcept {
  int level = 0;
  bool is_in_string = false;
  for (std::size_t at = 0; at < text.size() && level <= deepest_level; ++at) {
    const char c = text[at];
    if (c == '"') is_in_string = !is_in_string;
    if (is_in_string) {
      if (c == '\\') ++at;  // and the escaped character
    } else if (c == '{' || c == '[') {
      ++level;
    } else if (c == '}' || c == ']') {
      --level;
    }
  }
  return level <= deepest_level;
}

/// Parsed JSON; discarded: invalid, or too deep. Without exceptions, for programs that cannot catch any.
json parsed(std::string_view text) {
  if (!is_shallow(text)) return json(json::value_t::discarded);
  return json::parse(text.begin(), text.end(), nullptr, false);
}

/// Member of an object; null: missing, or not an object.
const json* member(const json& object, const char* key) {
  const auto at = object.find(key);
  return at == object.end() ? nullptr : &*at;
}

bool read_number(const json& object, const char* key, double largest, double& value) {
  const json* number = member(object, key);
  if (number == nullptr || !number->is_number()) return false;
  value = number->get<double>();
  return std::isfinite(value) && std::abs(value) <= largest;
}

/// Optional vector; a missing key leaves `vector` unchanged. False: present but invalid.
bool read_vector(const json& object, const char* key, double largest, std::optional<Vec3>& vector) {
  const json* found = member(object, key);
  if (found == nullptr) return true;
  Vec3 service;  // x to the right, y away from the user, z up
  if (!read_number(*found, "x", largest, service.x) || !read_number(*found, "y", largest, service.y) ||
      !read_number(*found, "z", largest, service.z))
    return false;
  vector = Vec3{service.x, service.z, -service.y};
  return true;
}

/// Optional quaternion; a missing key leaves `turn` unchanged, one without a direction means none. False: present but invalid.
bool read_turn(const json& object, const char* key, std::optional<Turn>& turn) {
  constexpr double largest = 2.0;
  // Of the length. More: a quaternion that means something else passes; less: rounding of the service's texts does not.
  constexpr double length_error = 0.01;
  const json* found = member(object, key);
  if (found == nullptr) return true;
  Turn service;  // about x to the right, y away from the user, z up
  if (!read_number(*found, "w", largest, service.w) || !read_number(*found, "x", largest, service.x) ||
      !read_number(*found, "y", largest, service.y) || !read_number(*found, "z", largest, service.z))
    return false;
  turn.reset();
  if (is_unit(service, length_error)) turn = unit_turn({service.w, service.x, service.z, -service.y});
  return true;
}

bool read_flag(const json& object, const char* key, bool& flag) {
  const json* found = member(object, key);
  if (found == nullptr) return true;
  if (!found->is_boolean()) return false;
  flag = found->get<bool>();
  return true;
}

bool read_button(const json& object, const char* key, std::uint32_t bit, std::uint32_t& buttons) {
  bool is_down = (buttons & bit) != 0;
  if (!read_flag(object, key, is_down)) return false;
  buttons = is_down ? buttons | bit : buttons & ~bit;
  return true;
}

/// Object within another; empty if missing; null: not an object.
const json* part(const json& object, const char* key) {
  static const json nothing = json::object();
  const json* found = member(object, key);
  if (found == nullptr) return &nothing;
  return found->is_object() ? found : nullptr;
}

bool read_arm(const json& entry, ServiceArm& arm) {
  const json* state = part(entry, "state");
  const json* status = part(entry, "status");
  if (state == nullptr || status == nullptr) return false;
  arm.reported_force_n.reset();
  return read_vector(*state, "cursor_position", furthest_m, arm.position_m) &&
         read_vector(*state, "cursor_velocity", fastest_m_per_s, arm.velocity_m_per_s) &&
         read_vector(*state, "current_cursor_force", strongest_n, arm.reported_force_n) &&
         read_flag(*status, "calibrated", arm.is_calibrated) && read_flag(*status, "power_supply", arm.has_power);
}

bool read_buttons(const json& state, ServiceGrip& grip) {
  if (!grip.is_wireless) return read_button(state, "button", 1, grip.buttons);
  const json* buttons = part(state, "buttons");
  return buttons != nullptr && read_button(*buttons, "a", 1, grip.buttons) && read_button(*buttons, "b", 2, grip.buttons) &&
         read_button(*buttons, "c", 4, grip.buttons);
}

bool read_grip(const json& entry, ServiceGrip& grip) {
  const json* state = part(entry, "state");
  const json* status = part(entry, "status");
  if (state == nullptr || status == nullptr || !read_buttons(*state, grip) || !read_turn(*state, "orientation", grip.turn) ||
      !read_flag(*status, "connected", grip.is_connected) || !read_flag(*status, "awake", grip.is_awake))
    return false;
  if (!grip.is_connected || !grip.is_awake) grip.buttons = 0;
  return true;
}

/// Calls `read(entry, device_id)` for each entry. False: not a list of devices, or `read` failed.
template <class Read>
bool read_list(const json& list, Read read) {
  if (!list.is_array() || list.size() > most_devices) return false;
  return std::ranges::all_of(list, [&](const json& entry) {
    const json* id = member(entry, "device_id");
    return id != nullptr && id->is_string() && is_plain(id->get_ref<const std::string&>()) &&
           read(entry, id->get_ref<const std::string&>());
  });
}

bool read_arms(const json& message, const std::string& device_id, ServiceView& view) {
  const std::optional<ServiceArm> before = std::exchange(view.arm, std::nullopt);
  view.device_ids.clear();
  const json* list = member(message, "inverse3");
  if (list == nullptr) return true;
  return read_list(*list, [&](const json& entry, const std::string& id) {
    view.device_ids.push_back(id);
    if (view.arm || (!device_id.empty() && id != device_id)) return true;
    view.arm = before.value_or(ServiceArm{});
    return read_arm(entry, *view.arm);
  });
}

bool read_grips(const json& message, const char* key, bool is_wireless, ServiceView& view) {
  const json* list = member(message, key);
  if (list == nullptr) return true;
  std::vector<ServiceGrip> grips;
  const bool is_right = read_list(*list, [&](const json& entry, const std::string& id) {
    const auto before = std::ranges::find_if(
        view.grips, [&](const ServiceGrip& grip) { return grip.is_wireless == is_wireless && grip.device_id == id; });
    grips.push_back(before != view.grips.end() ? *before : ServiceGrip{.device_id = id, .is_wireless = is_wireless});
    return read_grip(entry, grips.back());
  });
  std::erase_if(view.grips, [&](const ServiceGrip& grip) { return grip.is_wireless == is_wireless; });
  view.grips.insert(view.grips.end(), grips.begin(), grips.end());
  return is_right;
}

std::string number(double value) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end};
}

// A plain text needs no escapes.
std::string profile_words(const std::string& profile) { return R"("configure":{"profile":{"name":")" + profile + R"("}})"; }

}  // namespace

std::uint32_t ServiceView::buttons() const noexcept {
  std::uint32_t all = 0;
  for (const ServiceGrip& grip : grips) all |= grip.buttons;
  return all;
}

bool ServiceView::has(const ServiceGrip& grip) const noexcept {
  const ServiceGrip* const found = find(grip);
  return found != nullptr && found->is_connected;
}

const ServiceGrip* ServiceView::find(const ServiceGrip& grip) const noexcept {
  const auto found = std::ranges::find_if(
      grips, [&](const ServiceGrip& one) { return one.is_wireless == grip.is_wireless && one.device_id == grip.device_id; });
  return found == grips.end() ? nullptr : &*found;
}

bool read_message(std::string_view text, const std::string& device_id, ServiceView& view) {
  const json message = parsed(text);
  if (!message.is_object()) return false;
  ServiceView after = view;
  if (!read_arms(message, device_id, after) || !read_grips(message, "verse_grip", false, after) ||
      !read_grips(message, "wireless_verse_grip", true, after))
    return false;
  view = std::move(after);
  return true;
}

bool is_plain(std::string_view text) noexcept {
  constexpr std::size_t longest = 64;  // more than any id has; keeps sentences short
  return !text.empty() && text.size() <= longest && std::ranges::all_of(text, [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '-' || c == '.' ||
           c == ':';
  });
}

std::string force_message(const std::string& device_id, const Vec3& force_n, ForceWord word, const std::string& profile) {
  std::string text = profile.empty() ? "{" : R"({"session":{)" + profile_words(profile) + "},";
  text += R"("inverse3":[{"device_id":")" + device_id + R"(","commands":{"set_cursor_force":{")";
  text += word == ForceWord::vector ? "vector" : "values";
  text += R"(":{"x":)" + number(force_n.x) + R"(,"y":)" + number(-force_n.z) + R"(,"z":)" + number(force_n.y) + "}}}}]}";
  return text;
}

std::string snapshot_request(const std::string& profile) {
  return R"({"session":{)" + (profile.empty() ? "" : profile_words(profile) + ',') + R"("force_render_full_state":{}}})";
}

std::optional<ForceWord> word_of_version(std::string_view answer) {
  const json message = parsed(answer);
  const json* data = message.is_object() ? part(message, "data") : nullptr;
  if (data == nullptr) return std::nullopt;
  for (const json* holder : {data, &message}) {
    for (const char* key : {"project_version", "git_tag"}) {
      const json* found = member(*holder, key);
      if (found == nullptr || !found->is_string()) continue;
      std::string_view version = found->get_ref<const std::string&>();
      if (version.starts_with('v')) version.remove_prefix(1);
      std::pair<int, int> parts;
      const char* const end = version.data() + version.size();
      const auto [dot, error] = std::from_chars(version.data(), end, parts.first);
      if (error != std::errc{} || dot == end || *dot != '.') continue;
      if (std::from_chars(dot + 1, end, parts.second).ec != std::errc{}) continue;
      return parts >= first_with_vector ? ForceWord::vector : ForceWord::values;
    }
  }
  return std::nullopt;
}

}  // namespace palpa::inverse3
