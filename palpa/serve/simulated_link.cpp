#include "palpa/serve/simulated_link.h"

#include <algorithm>
#include <string_view>

#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"
#include "palpa/device/described.h"

namespace palpa {

LinkOptions link_options(const std::string& description) {
  LinkOptions options;
  std::string_view rest = description;
  while (!rest.empty()) {
    const std::string_view word = detail::next_word(rest);
    const auto [key, text] = detail::key_and_value(word);
    double value = 0.0;
    const bool is_number = detail::read_number(text, value);
    const auto within = [&](double most) { return is_number && value >= 0.0 && value <= most; };
    bool is_known = true;
    if ((key == "delay_ms" || key == "delay") && within(10e3)) {
      options.delay_s = 1e-3 * value;
    } else if ((key == "jitter_ms" || key == "jitter") && within(10e3)) {
      options.jitter_s = 1e-3 * value;
    } else if (key == "loss" && within(1.0)) {
      options.loss = value;
    } else if (key == "reliable" && (text == "0" || text == "1")) {
      options.reliable = text == "1";
    } else if (key == "seed" && within(0x1p53)) {
      options.seed = static_cast<std::uint64_t>(value);
    } else {
      is_known = false;
    }
    if (!is_known) {
      throw LoadError(
          "--link: " + detail::in_quotes(word) +
          " is no setting of a link; write delay_ms=20,jitter_ms=3,loss=0.01,reliable=1,seed=1, times up to 10000 ms, "
          "loss from 0 to 1");
    }
  }
  return options;
}

// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): equal seeds give equal links on every machine.
double SimulatedLink::random() noexcept {
  std::uint64_t z = random_ += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

void SimulatedLink::send(std::span<const std::byte> message, double now_s) {
  const double shift_s = options_.jitter_s * (2.0 * random() - 1.0);
  const bool is_lost = random() < options_.loss;
  double arrives_s = now_s + std::max(0.0, options_.delay_s + shift_s);
  if (options_.reliable) {
    // Sent once more when its acknowledgement has not come: a round trip and a half after it was sent.
    if (is_lost) arrives_s += 2.0 * options_.delay_s + retry_s;
    arrives_s = last_s_ = std::max(last_s_, arrives_s);
  } else if (is_lost) {
    return;
  }
  under_way_.push_back({arrives_s, sent_++, {message.begin(), message.end()}});
}

std::span<const std::byte> SimulatedLink::receive(double now_s) {
  const auto first =
      std::ranges::min_element(under_way_, {}, [](const Message& m) { return std::pair(m.arrives_s, m.number); });
  if (first == under_way_.end() || first->arrives_s > now_s) return {};
  received_ = std::move(first->bytes);
  under_way_.erase(first);
  return received_;
}

}  // namespace palpa
