#include "bench/haptics/run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace palpa::haptics {

namespace {

double time_quantile(std::vector<double> values, double share) {
  if (values.empty()) return -1.0;
  const auto at =
      std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1, 0);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  // Zero has no sign.
  const bool is_zero = std::string(text).find_first_not_of("-0.") == std::string::npos;
  return is_zero && text[0] == '-' ? text + 1 : text;
}

std::vector<std::string> in_order(const std::vector<Result>& results, std::string Result::*of) {
  std::vector<std::string> names;
  for (const Result& result : results) {
    if (std::find(names.begin(), names.end(), result.*of) == names.end()) names.push_back(result.*of);
  }
  return names;
}

std::vector<const Result*> of(const std::vector<Result>& results, const std::string& family, const std::string& renderer) {
  std::vector<const Result*> found;
  for (const Result& result : results) {
    if (result.family == family && result.renderer == renderer) found.push_back(&result);
  }
  return found;
}

std::string cases_of(const std::vector<const Result*>& results) {
  std::ptrdiff_t known = 0, failed = 0;
  for (const Result* result : results) {
    known += result->end != Answer::End::unsupported;
    failed += result->end == Answer::End::failed;
  }
  std::string text = std::to_string(known) + " of " + std::to_string(results.size());
  return failed > 0 ? text + ", " + std::to_string(failed) + " failed" : text;
}

std::string cell(const std::vector<const Result*>& results, const Metric& metric) {
  double sum = 0.0;
  int count = 0;
  for (const Result* result : results) {
    const auto found = result->scores.find(metric.name);
    if (found == result->scores.end()) continue;
    sum += found->second;
    ++count;
  }
  if (count == 0) return "–";
  return std::isfinite(sum) ? formatted(metric.format, sum / count) : "not held";
}

std::string quoted(std::string text) {
  for (char& c : text) c = c == '"' || c == '\n' ? '\'' : c;
  return '"' + text + '"';
}

const char* format_end(Answer::End end) {
  return end == Answer::End::whole ? "whole" : end == Answer::End::failed ? "failed" : "unsupported";
}

}  // namespace

NamedRenderer named(const std::string& argument) {
  const std::size_t at = argument.find('=');
  const std::string name = argument.substr(0, at);
  if (at == std::string::npos || name.find_first_of(" /") != std::string::npos) return {argument, argument};
  return {name, argument.substr(at + 1)};
}

std::vector<Result> run(const std::filesystem::path& folder, const std::vector<NamedRenderer>& renderers, bool quick) {
  std::vector<Result> results;
  for (const MadeCase& one : read_cases(folder, quick)) {
    for (const NamedRenderer& renderer : renderers) {
      std::fprintf(stderr, "%s: %s\n", one.name.c_str(), renderer.name.c_str());
      const Answer answer = render(renderer.command, one.file, one.probe_lines, force_limit_n);
      Result result{
          .renderer = renderer.name, .family = one.family, .name = one.name, .end = answer.end, .reason = answer.reason};
      if (answer.end != Answer::End::unsupported) result.scores = score(one, answer.forces_n, folder / "truth");
      result.load_s = answer.load_s;
      result.ticks = answer.outside_us.size();
      result.outside_p50_us = time_quantile(answer.outside_us, 0.5);
      result.outside_p99_us = time_quantile(answer.outside_us, 0.99);
      result.inside_p50_us = time_quantile(answer.inside_us, 0.5);
      result.inside_p99_us = time_quantile(answer.inside_us, 0.99);
      results.push_back(std::move(result));
    }
  }
  return results;
}

std::string tables(const std::vector<Result>& results) {
  std::string text;
  for (const std::string& family : in_order(results, &Result::family)) {
    std::vector<const Metric*> columns;
    for (const Metric& metric : metrics) {
      const bool scored = std::any_of(results.begin(), results.end(), [&](const Result& result) {
        return result.family == family && result.scores.contains(metric.name);
      });
      if (scored) columns.push_back(&metric);
    }
    text += "### " + family + "\n\n| renderer | cases |";
    for (const Metric* column : columns) text += std::string(" ") + column->heading + " |";
    text += "\n|---|---|";
    for (std::size_t i = 0; i < columns.size(); ++i) text += "---|";
    text += "\n";
    for (const std::string& renderer : in_order(results, &Result::renderer)) {
      const auto own = of(results, family, renderer);
      text += "| " + renderer + " | " + cases_of(own) + " |";
      for (const Metric* column : columns) text += " " + cell(own, *column) + " |";
      text += "\n";
    }
    text += "\n";
  }
  return text;
}

std::string time_table(const std::vector<Result>& results) {
  std::string text =
      "| renderer | tick inside, p50 µs | worst p99 µs | tick outside, p50 µs | worst p99 µs | longest load s "
      "|\n|---|---|---|---|---|---|\n";
  for (const std::string& renderer : in_order(results, &Result::renderer)) {
    std::vector<double> inside, outside;
    double inside_p99 = -1.0, outside_p99 = -1.0, load_s = 0.0;
    for (const Result& result : results) {
      if (result.renderer != renderer || result.ticks == 0) continue;
      if (result.inside_p50_us >= 0.0) inside.push_back(result.inside_p50_us);
      outside.push_back(result.outside_p50_us);
      inside_p99 = std::max(inside_p99, result.inside_p99_us);
      outside_p99 = std::max(outside_p99, result.outside_p99_us);
      load_s = std::max(load_s, result.load_s);
    }
    const auto time = [](double us) { return us < 0.0 ? std::string("–") : formatted("%.1f", us); };
    text += "| " + renderer + " | " + time(time_quantile(inside, 0.5)) + " | " + time(inside_p99) + " | " +
            time(time_quantile(outside, 0.5)) + " | " + time(outside_p99) + " | " + formatted("%.2f", load_s) + " |\n";
  }
  return text;
}

std::string score_rows(const std::vector<Result>& results) {
  std::string text = "family,case,renderer,end,reason";
  for (const Metric& metric : metrics) text += std::string(",") + metric.name;
  text += "\n";
  for (const Result& result : results) {
    text += result.family + "," + result.name + "," + quoted(result.renderer) + "," + format_end(result.end) + "," +
            quoted(result.reason);
    for (const Metric& metric : metrics) {
      const auto found = result.scores.find(metric.name);
      text += "," + (found == result.scores.end() ? std::string() : formatted("%.6g", found->second));
    }
    text += "\n";
  }
  return text;
}

std::string time_rows(const std::vector<Result>& results) {
  std::string text = "family,case,renderer,ticks,load_s,outside_p50_us,outside_p99_us,inside_p50_us,inside_p99_us\n";
  for (const Result& result : results) {
    const auto time = [](double us) { return us < 0.0 ? std::string() : formatted("%.2f", us); };
    text += result.family + "," + result.name + "," + quoted(result.renderer) + "," + std::to_string(result.ticks) + "," +
            formatted("%.3f", result.load_s) + "," + time(result.outside_p50_us) + "," + time(result.outside_p99_us) + "," +
            time(result.inside_p50_us) + "," + time(result.inside_p99_us) + "\n";
  }
  return text;
}

}  // namespace palpa::haptics
