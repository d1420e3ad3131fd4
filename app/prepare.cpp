#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/file/derive_store.h"
#include "palpa/file/prepare_store.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

std::string count_of(std::int64_t number, const char* one, const char* many) {
  return detail::grouped(std::to_string(number)) + " " + (number == 1 ? one : many);
}

std::string octaves_words(const PreparedStore& prepared) {
  if (prepared.last_octave < prepared.first_octave) return "no octaves missing";
  if (prepared.last_octave == prepared.first_octave) return "octave " + std::to_string(prepared.last_octave);
  return "octaves " + std::to_string(prepared.first_octave) + " to " + std::to_string(prepared.last_octave);
}

std::string speed_words(const PreparedStore& prepared) {
  if (prepared.voxels == 0) return "";
  const double seconds = std::max(prepared.seconds, 1e-9);
  return detail::text(", in %.1f s on %d %s: %.2f ns a voxel", seconds, prepared.threads,
                      prepared.threads == 1 ? "core" : "cores", 1e9 * seconds / static_cast<double>(prepared.voxels));
}

Json summary_of(const PreparedStore& prepared) {
  return {{"units", prepared.units},
          {"units_done_before", prepared.units_before},
          {"units_missing", prepared.units_missing},
          {"unit_voxels", prepared.unit},
          {"first_octave", prepared.first_octave},
          {"last_octave", prepared.last_octave},
          {"chunks_with_facts", prepared.chunks_read},
          {"chunks_written", prepared.chunks_written},
          {"voxels", prepared.voxels},
          {"seconds", prepared.seconds},
          {"threads", prepared.threads},
          {"finished", prepared.is_finished},
          {"wrong_chunks", prepared.wrong}};
}

}  // namespace

std::string prepared_words(const std::filesystem::path& store, const PreparedStore& prepared) {
  const auto& unit = prepared.unit;
  std::string words = "Prepared " + store.string() + ": " + count_of(prepared.units, "unit", "units") + " of " +
                      detail::text("%lld x %lld x %lld voxels", static_cast<long long>(unit[0]),
                                   static_cast<long long>(unit[1]), static_cast<long long>(unit[2]));
  if (prepared.units_before > 0) words += ", " + detail::grouped(std::to_string(prepared.units_before)) + " of them before";
  words += "; " + octaves_words(prepared) + ", " + count_of(prepared.chunks_written, "chunk", "chunks") + " written" +
           speed_words(prepared) + "\n";
  if (!prepared.is_finished) {
    words += prepared.units_missing > 0
                 ? count_of(prepared.units_missing, "unit is", "units are") + " missing: the other parts make them\n"
                 : "all units are there; a last call without --part makes the coarsest octaves and the attributes\n";
  }
  return words;
}

int run_prepare(PrepareArguments arguments, const std::atomic<bool>& stop) {
  PreparedStore prepared;
  arguments.options.stop = &stop;
  std::optional<DerivedArray> derive;
  if (!arguments.derive.empty()) derive = derived_array(arguments.derive);
  const std::filesystem::path made = derive ? derived_store(arguments.store, name_of(*derive)) : arguments.store;
  {
    Progress progress((arguments.check ? "checking " : "preparing ") + arguments.store.filename().string());
    arguments.options.progress = [&](double share) { progress.show(share); };
    prepared = arguments.check ? check_prepared_store(made, arguments.options)
               : derive        ? derive_store(arguments.store, *derive, arguments.options)
                               : prepare_store(made, arguments.options);
  }
  if (arguments.json) {
    Json json = summary_of(prepared);
    json["wrong"] = prepared.wrong_chunks;
    print(json.dump(2) + "\n");
    return prepared.wrong > 0 ? 1 : 0;
  }
  if (derive && !arguments.check && arguments.options.is_one_part) {
    const WorkPart& part = arguments.options.part;
    tell("Wrote part " + std::to_string(part.number) + " of " + std::to_string(part.of) + " of " + made.string() +
         "; after the last part the same command without --part makes its octaves\n");
    return 0;
  }
  if (!arguments.check) return tell(prepared_words(made, prepared)), 0;
  for (const std::string& sentence : prepared.wrong_chunks) print(made.string() + ": " + sentence + "\n");
  if (prepared.wrong > static_cast<std::int64_t>(prepared.wrong_chunks.size()))
    print("and " + count_of(prepared.wrong - static_cast<std::int64_t>(prepared.wrong_chunks.size()), "more", "more") + "\n");
  print((prepared.wrong == 0 ? "All of " + count_of(prepared.chunks_read, "chunk is", "chunks are") + " as prepared"
                             : count_of(prepared.wrong, "chunk is", "chunks are") + " wrong, of " +
                                   detail::grouped(std::to_string(prepared.chunks_read))) +
        speed_words(prepared) + "\n");
  return prepared.wrong > 0 ? 1 : 0;
}

}  // namespace palpa::app
