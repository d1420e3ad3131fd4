#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/study/energy_table.h"
#include "palpa/trace/trace.h"

namespace palpa::app {

namespace {

using Json = nlohmann::ordered_json;

Json answer(const ReplayResult& result) {
  return {{"same", result.difference.same},
          {"where", result.difference.where},
          {"ticks", result.difference.ticks},
          {"ticks_per_s", result.summary.ticks_per_s},
          {"energy_j", Json::parse(to_json(energy_table(result.summary)))}};
}

std::string sentence(const ReplayResult& result) {
  const TraceDifference& difference = result.difference;
  return difference.same ? detail::text("identical in all %lld ticks\n", static_cast<long long>(difference.ticks))
                         : detail::text("differs at %s\n", difference.where.c_str());
}

}  // namespace

int run_replay(const ReplayArguments& arguments, const std::atomic<bool>& stop) {
  const std::vector<std::filesystem::path> traces = traces_in(arguments.trace);
  const bool is_of_hands = traces.front() != arguments.trace;
  Json answers = Json::object();
  bool all_same = true;
  for (const std::filesystem::path& trace : traces) {
    ReplayResult result;
    {
      Progress progress("replaying " + trace.string());
      result = replay(trace, arguments.data_folders, arguments.read, &stop, arguments.plugins,
                      [&](double share) { progress.show(share); });
    }
    if (result.interrupted) return 0;
    all_same = all_same && result.difference.same;
    const std::string hand = trace.filename().string();
    if (!result.cut.empty()) print_warnings({(is_of_hands ? hand + ": " : "") + "the trace was replayed up to " + result.cut});
    if (!arguments.json) {
      print((is_of_hands ? hand + ": " : "") + sentence(result));
    } else if (is_of_hands) {
      answers[hand] = answer(result);
    } else {
      answers = answer(result);
    }
  }
  if (arguments.json) print(answers.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  return all_same ? 0 : 1;
}

}  // namespace palpa::app
