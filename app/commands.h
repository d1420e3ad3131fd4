// Commands of `palpa`: each prints its result and returns exit code 0, or 1 for a negative answer; wrong input throws
// LoadError.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/file/convert.h"
#include "palpa/file/prepare_store.h"
#include "palpa/study/run.h"

namespace palpa::app {

/// Data on another machine.
struct FarArguments {
  std::string data_at;  ///< HOST:PORT; empty: the data are here
  std::string token;    ///< empty: of the environment, or asked for
  bool tls = false;
  std::filesystem::path authority;  ///< of its certificate, PEM; empty: one that the system knows
  bool unencrypted = false;         ///< also to other machines
  bool datagrams = false;           ///< probes and models by UDP
  std::string link;                 ///< simulated, for `link_options`; empty: none
  bool far_anyway = false;          ///< beyond 20 ms
};

struct RunArguments {
  RunOptions options;
  FarArguments far;
  std::vector<std::string> hands, devices;  ///< for `prepare_hands`, if either names several; else in `options`
  std::optional<std::uint16_t> igtl_port;   ///< of a live run: for 3D Slicer; none: no view
  bool dry_run = false;
  bool json = false;
};
int run_scene(RunArguments arguments, const std::atomic<bool>& stop);

/// Feels data of another machine. Throws LoadError for options that are the data's side's.
int run_far(const RunArguments& arguments, const std::atomic<bool>& stop);
/// Measures the link to it.
int check_link(const FarArguments& arguments, bool as_json, const std::atomic<bool>& stop);

struct ServeArguments {
  RunOptions options;  ///< its scene, trace and how they are read
  std::string listen = "127.0.0.1";
  std::uint16_t port = 4711;
  std::filesystem::path token_file, certificate, key;  ///< empty: none
  bool unencrypted = false;                            ///< also to other machines
  bool datagrams = false;                              ///< probes and models by UDP
  std::optional<std::uint16_t> igtl_port{};            ///< for 3D Slicer on this machine; none: no view
};
int run_serve(const ServeArguments& arguments, const std::atomic<bool>& stop);

struct DemoArguments {
  std::string name = "head";   ///< head, flow or wing
  std::filesystem::path data;  ///< folder of the real data; empty: embedded data, or the head of tools/get-ct-head if present
  std::filesystem::path out;   ///< folder for the recording; empty: palpa-demo in the current folder
  std::string device;          ///< simulated device, for `device_plant`; empty: an ideal device
  bool json = false;
  ReadOptions read;
};
int run_demo(const DemoArguments& arguments, const std::atomic<bool>& stop);

struct CheckArguments {
  std::filesystem::path scene;
  std::string device;             ///< for `device_plant`
  std::filesystem::path fix;      ///< new scene file with the changes; empty: none
  std::filesystem::path picture;  ///< new PNG file; empty: none
  detail::Existing existing = detail::Existing::refused;
  SceneOptions scene_options;
  std::vector<std::filesystem::path> plugins;
  bool json = false;
  ReadOptions read;
};
int run_check(const CheckArguments& arguments);

struct DevicesArguments {
  std::string name;    ///< of one kind, with settings; empty: all
  bool setup = false;  ///< measure that device
  bool json = false;
};
int run_devices(const DevicesArguments& arguments, const std::atomic<bool>& stop);

struct ExploreArguments {
  std::vector<std::string> files;  ///< scene, data or trace; none: the start page
  std::vector<std::string> data_folders;
  std::string device;        ///< with settings, as in run; empty: the mouse
  std::string screenshot;    ///< new PNG of the window once it is drawn; empty: none
  std::string quit_after_s;  ///< [s] as written; empty: the window stays
};
/// Replaces the process by palpa-explorer (exec). Throws LoadError if it is not installed.
int run_explore(const ExploreArguments& arguments);

struct ConvertArguments {
  VolumeRequest request;      ///< one volume
  std::filesystem::path out;  ///< .nrrd, .nhdr, .nii, .nii.gz or .vti, a new file; or .zarr, a folder
  std::string crop;           ///< from the command line; empty: none
  ConvertOptions options;     ///< all but the crop
  ReadOptions read;
};
int run_convert(ConvertArguments arguments, const std::atomic<bool>& stop);

struct PrepareArguments {
  std::filesystem::path store;
  PrepareOptions options;
  std::string derive;  ///< "q=velocity": writes this field of the store instead; empty: none
  bool check = false;  ///< read everything anew instead
  bool json = false;
};
int run_prepare(PrepareArguments arguments, const std::atomic<bool>& stop);
/// Last line of a preparation.
std::string prepared_words(const std::filesystem::path& store, const PreparedStore& prepared);

struct ExportArguments {
  std::filesystem::path trace;
  std::filesystem::path out;  ///< .vtp, .csv, .h5 or .mrk.json
  detail::Existing existing = detail::Existing::refused;
};
int run_export(const ExportArguments& arguments);

struct ReplayArguments {
  std::filesystem::path trace;
  std::vector<std::filesystem::path> data_folders;
  std::vector<std::filesystem::path> plugins;
  bool json = false;
  ReadOptions read;
};
int run_replay(const ReplayArguments& arguments, const std::atomic<bool>& stop);

struct ReportArguments {
  std::filesystem::path trace;
  std::filesystem::path beside;    ///< another trace of the hand, for comparison; empty: none
  std::filesystem::path out;       ///< empty: report.html in the trace, of two beside.html
  std::filesystem::path pictures;  ///< folder for the pictures as files; empty: none
  bool full_paths = false;         ///< whole paths in the page, not only last names
  bool force = false;              ///< replace existing files
  std::vector<std::filesystem::path> data_folders;
  std::vector<std::filesystem::path> plugins;
  ReadOptions read;
};
int run_report(const ReportArguments& arguments);

struct MapArguments {
  std::filesystem::path scene;
  std::filesystem::path out;      ///< .vti; a new file
  std::filesystem::path picture;  ///< .png; empty: none
  bool grid = false;              ///< a cube instead of a slice
  std::string slice = "x";        ///< normal to this axis of the hand
  double at_mm = 0.0;             ///< position of the slice on the axis
  double size_mm = 180.0;
  int points = 0;        ///< [1] along each side; 0: 256 of a slice, 64 of a grid
  int threads = 0;       ///< [1] 0: one per core
  WorkPart part;         ///< of the paths
  bool is_part = false;  ///< felt into a file of its own, which a call without parts joins
  bool json = false;
  detail::Existing existing = detail::Existing::refused;
  SceneOptions scene_options;
  std::vector<std::filesystem::path> plugins;
  ReadOptions read;
};
int run_map(const MapArguments& arguments, const std::atomic<bool>& stop);

struct ModesArguments {
  std::string type;  ///< empty: a list of all
  std::vector<std::filesystem::path> plugins;
  bool json = false;
};
int run_modes(const ModesArguments& arguments);

}  // namespace palpa::app
