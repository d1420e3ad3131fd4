// Command lines for data.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/command_lines.h"
#include "app/commands.h"
#include "app/info.h"
#include "app/options.h"
#include "palpa/base/load_error.h"

namespace palpa::app {

namespace {

struct InfoLine {
  InfoArguments info;
  bool force = false;
  std::vector<std::string> at, at_m;
  std::string scene_file;
  HowToRead how;
};

InfoArguments arguments_of(InfoLine given, bool scene) {
  InfoArguments& info = given.info;
  info.read.preview = true;
  info.read.checksums = info.json ? Checksums::now : Checksums::none;
  info.request = request_of(given.how);
  for (const std::string& position : given.at_m) info.places.push_back(asked_place_m(position));
  for (const std::string& place : given.at) info.places.push_back(asked_place(place));
  info.scene = scene;
  info.scene_file = given.scene_file;
  info.existing = existing(given.force);
  if (!given.scene_file.empty() && info.scene_file.extension() != ".toml") {
    throw LoadError("--scene " + given.scene_file +
                    ": is no name of a scene; write --scene OUT.toml, or put --scene behind the file");
  }
  return std::move(info);
}

}  // namespace

void add_info(CLI::App& app, Work& work) {
  const auto given = std::make_shared<InfoLine>();
  CLI::App* command = app.add_subcommand("info", "Describe data files, draw them, suggest a first scene");
  command
      ->add_option("FILE", given->info.files,
                   "files or folders, each a volume of its own; a pattern in quotes, as 'phase_*.vti', is one time series")
      ->required()
      ->type_name("");
  add_repeated(command, "--at", given->at,
               "print the values at a voxel, as 120,200,90, at a position, as -5mm,16mm,7mm, or in the patient, as "
               "R5,A16,S7 (millimetres to the right or left, front or back, head or feet)")
      ->type_name("PLACE");
  add_repeated(command, "--at-m", given->at_m, "print the values at this position of the world, in metres")->type_name("X,Y,Z");
  command->add_flag("--series", given->info.series, "the files are the frames of one time series");
  command
      ->add_option("--level", given->info.level,
                   "print how much of the thin parts above this value the smooth filter loses, and how far the level moves "
                   "from frame to frame")
      ->type_name("VALUE");
  command->add_flag("--json", given->info.json, "print as JSON");
  CLI::Option* scene_option =
      command->add_option("--scene", given->scene_file, "suggest a first scene, printed or written into this new file")
          ->expected(0, 1)
          ->type_name("[OUT.toml]");
  command->add_option("--picture", given->info.picture, "draw slices, streamlines and histogram into this new PNG file")
      ->type_name("FILE.png");
  add_force(command, given->force);
  add_how_to_read(command, given->how);
  add_reader(command, given->info.read);
  command->footer("Example:\n  palpa info head.nrrd --at 120,200,90 --picture head.png");
  command->callback([=, &work] { work = [=] { return run_info(arguments_of(*given, scene_option->count() > 0)); }; });
}

namespace {

struct ConvertLine {
  ConvertArguments convert;
  bool force = false;
  std::string in, part;
  HowToRead how;
};

}  // namespace

void add_convert(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<ConvertLine>();
  CLI::App* command =
      app.add_subcommand("convert", "Write data as NRRD, NIfTI, VTI or OME-Zarr: whole, a part, coarser, or on another grid");
  command->add_option("IN", given->in, "a file or folder of data")->required()->type_name("");
  command->add_option("OUT", given->convert.out, "new file: .nrrd, .nhdr, .nii, .nii.gz or .vti; or a new folder .zarr")
      ->required()
      ->type_name("");
  command->add_option("--crop", given->convert.crop, "only these voxels, first and last of each axis")
      ->type_name("I0:I1,J0:J1,K0:K1");
  command->add_option("--downsample", given->convert.options.downsample, "the mean of N x N x N voxels becomes one")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  command
      ->add_option("--resample-m", given->convert.options.resample_m,
                   "onto cubes of this size along the world's axes; NaN outside the data")
      ->check(CLI::PositiveNumber)
      ->type_name("M");
  command->add_flag("--int16", given->convert.options.int16, "round to whole numbers of 16 bits");
  command->add_option("--field", given->convert.options.field, "only this field")->type_name("NAME");
  add_part(command, given->part, "of a .zarr write only these slices; 'palpa prepare' then makes the coarser octaves");
  command
      ->add_option("--zarr", given->convert.options.zarr,
                   "version of a .zarr: 2 (OME-Zarr 0.4), or 3 (0.5, with shards); by itself 3 from a million chunks on")
      ->check(CLI::IsMember({2, 3}))
      ->type_name("V");
  add_force(command, given->force);
  add_how_to_read(command, given->how);
  add_reader(command, given->convert.read);
  command->footer("Example:\n  palpa convert head.nrrd small.nrrd --downsample 2");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      ConvertArguments& convert = given->convert;
      convert.options.existing = existing(given->force);
      if (!given->part.empty()) convert.options.part = work_part(given->part), convert.options.shares_store = true;
      convert.request = request_of(given->how);
      convert.request.files.insert(convert.request.files.begin(), given->in);
      return run_convert(std::move(convert), stop);
    };
  });
}

namespace {

struct PrepareLine {
  PrepareArguments prepare;
  std::string part;
};

}  // namespace

void add_prepare(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<PrepareLine>();
  PrepareArguments& prepare = given->prepare;
  CLI::App* command =
      app.add_subcommand("prepare", "Make an OME-Zarr store ready: its coarser octaves, and range and checksum of each chunk");
  command->add_option("STORE", prepare.store, "folder of an OME-Zarr image")->required()->type_name("");
  add_part(command, given->part, "make only these units of 1024 x 1024 x 1024 voxels; a last call without it makes the rest");
  command->add_option("--into", prepare.options.into, "write beside a store that must not be changed, into this folder")
      ->type_name("MINE.zarr");
  command
      ->add_flag("--check", prepare.check,
                 "write nothing: is each chunk there, whole, as it was, and the mean of those below it?")
      ->excludes("--into");
  command
      ->add_option("--derive", prepare.derive,
                   "write a derived field of the store, as in q=velocity, and its octaves: curl, divergence, "
                   "gradient_magnitude, q, lambda2; of a part its slices alone")
      ->type_name("FUNC=FIELD")
      ->excludes("--into");
  command->add_option("--threads", prepare.options.threads, "number of cores to use (all, of one part one)")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  command->add_flag("--json", prepare.json, "print the summary as JSON");
  add_reader(command, prepare.options.read);
  command->footer("Example:\n  mpirun -n 64 palpa prepare BIG.zarr --part auto && palpa prepare BIG.zarr");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      if (!given->part.empty()) given->prepare.options.part = work_part(given->part), given->prepare.options.is_one_part = true;
      return run_prepare(std::move(given->prepare), stop);
    };
  });
}

}  // namespace palpa::app
