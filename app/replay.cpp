#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/study/energy_table.h"

namespace palpa::app {

int run_replay(const ReplayArguments& arguments, const std::atomic<bool>& stop) {
  ReplayResult result;
  {
    Progress progress("replaying " + arguments.trace.string());
    result = replay(arguments.trace, arguments.data_folders, arguments.read, &stop, arguments.plugins,
                    [&](double share) { progress.show(share); });
  }
  if (result.interrupted) return 0;
  const TraceDifference& difference = result.difference;
  if (!result.cut.empty()) print_warnings({"the trace was replayed up to " + result.cut});
  if (arguments.json) {
    const nlohmann::ordered_json json{{"same", difference.same},
                                      {"where", difference.where},
                                      {"ticks", difference.ticks},
                                      {"ticks_per_s", result.summary.ticks_per_s},
                                      {"energy_j", nlohmann::ordered_json::parse(to_json(energy_table(result.summary)))}};
    print(detail::text("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str()));
  } else if (difference.same) {
    print(detail::text("identical in all %lld ticks\n", static_cast<long long>(difference.ticks)));
  } else {
    print(detail::text("differs at %s\n", difference.where.c_str()));
  }
  return difference.same ? 0 : 1;
}

}  // namespace palpa::app
