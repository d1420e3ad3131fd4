#include "explorer/opening.h"

#include <QCoreApplication>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "palpa/base/scenes_folder.h"
#include "palpa/file/components.h"
#include "palpa/file/directions.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/first_scene.h"
#include "palpa/study/recorded_scene.h"
#include "palpa/trace/trace.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

namespace {

QString tr(const char* words) { return QCoreApplication::translate("palpa::explorer::Opening", words); }

/// Ends the reading of a file before its voxels.
struct Enough {};

/// [1] Files of a folder that is searched for the other slices of a series unasked. More: a slice in a large archive waits for
/// all of it; fewer: large series have to be opened by their folder.
constexpr int most_unasked = 3000;

bool is_small(const fs::path& folder) {
  std::error_code problem;
  int count = 0;
  for (fs::recursive_directory_iterator entry(folder, problem), end; !problem && entry != end; entry.increment(problem))
    if (++count > most_unasked) return false;
  return !problem;
}

FileContents list(const VolumeRequest& request, std::stop_token stop) {
  FileContents contents;
  const ReadOptions read{.stop = stop, .found = [&](const FileContents& found) {
                           contents = found;
                           throw Enough();
                         }};
  try {
    read_volume(request, read);
  } catch (const Enough&) {
  }
  return contents;
}

QString folder_name(const fs::path& path) {
  return QString::fromStdString((path.has_filename() ? path : path.parent_path()).filename().string());
}

VolumeRequest request_of(const Wanted& wanted) {
  VolumeRequest request;
  for (const fs::path& path : wanted.paths) request.files.push_back(fs::absolute(path));
  request.series = wanted.series;
  request.fields = wanted.fields;
  return request;
}

bool is_slice_of_more(const FileContents& contents, const VolumeRequest& request) {
  std::error_code ignored;
  return contents.format == "dicom" && contents.series.size() == 1 && contents.series.front().number == 1 &&
         !contents.arrays.empty() && contents.arrays.front().dims[2] == 1 &&
         fs::is_regular_file(request.files.front(), ignored) && is_small(request.files.front().parent_path());
}

/// Request for all slices of a single slice's series, if its folder has more of them.
std::optional<VolumeRequest> whole_series(const VolumeRequest& request, std::stop_token stop, QStringList& notes) {
  VolumeRequest all = request;
  std::vector<FilePart> series;
  try {
    const FileContents alone = list(request, stop);
    if (!is_slice_of_more(alone, request)) return std::nullopt;
    all.files = {request.files.front().parent_path()};
    all.series = alone.series.front().name;
    series = list(all, stop).series;
  } catch (const LoadError&) {
    return std::nullopt;  // the file itself is read, with its own error
  }
  const auto whole = std::ranges::find(series, all.series, &FilePart::name);
  if (whole == series.end() || whole->number < 2) return std::nullopt;
  notes << tr("%1 is one of %2 slices: the whole series is opened.")
               .arg(QString::fromStdString(request.files.front().filename().string()))
               .arg(whole->number);
  return all;
}

bool is_dicom_name(const fs::path& path) {
  std::string end = path.extension().string();
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  // DICOM files often have no ending, or a number of a slice or UID.
  return end == ".dcm" || end == ".ima" || end == ".dicom" || end.size() < 2 ||
         std::all_of(end.begin() + 1, end.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// Angle of a CT's slices to their normal direction, in words; empty: none.
QString gantry_tilt(const Volume& volume) {
  const GridView* grid = grid_behind(*volume.fields.front().field);
  if (volume.format != "dicom" || volume.modality != "CT" || !grid) return {};
  constexpr double least_deg = 0.1;  // less is rounded
  const Mat3 steps = transposed(grid->geometry.index_to_world_m);
  const double along = std::abs(dot(normalized(steps.row[2]), normalized(cross(steps.row[0], steps.row[1]))));
  const double tilt_deg = std::acos(std::min(1.0, along)) * 180.0 / M_PI;
  if (!(tilt_deg > least_deg)) return {};
  return tr("The slices have a gantry tilt of %1°: they are shown and felt where they were measured.").arg(tilt_deg, 0, 'g', 3);
}

VolumeRequest first_of(VolumeRequest request) {
  request.files.resize(1);
  return request;
}

/// The scene that is suggested for data, and what it was made from.
class Data {
 public:
  Data(const Wanted& wanted, std::stop_token stop) : wanted_(wanted), stop_(stop), request_(request_of(wanted)) {}

  Found opened() {
    std::error_code ignored;
    // Of several images of a series one stands for all.
    if (request_.files.size() > 1 && is_dicom_name(request_.files.front()) && list(first_of(request_), stop_).format == "dicom")
      request_ = first_of(request_);
    if (!wanted_.is_decided && request_.files.size() == 1 && request_.series.empty() &&
        fs::is_regular_file(request_.files.front(), ignored) && is_dicom_name(request_.files.front())) {
      if (const auto all = whole_series(request_, stop_, notes_)) request_ = *all;
    }
    try {
      read();
    } catch (const Enough&) {
      return {std::nullopt, file_.contents};
    }
    if (const QString tilt = gantry_tilt(file_.volume); !tilt.isEmpty()) notes_ << tilt;
    if (!wanted_.beside.empty()) {
      VolumeRequest beside;
      beside.files = {fs::absolute(wanted_.beside)};
      beside_ = read_volume(beside, {.checksums = Checksums::later, .stop = stop_});
    }
    Opened opened{.loaded = suggested(), .scene_file = {}, .trace = {}, .title = title()};
    opened.request = request_, opened.notes = notes_;
    if (!beside_ && has_only_vectors()) opened.beside = find_beside(wanted_.paths.front());
    return {std::move(opened), {}};
  }

 private:
  QString title() const { return QString::fromStdString(wanted_.paths.front().filename().string()); }

  bool has_only_vectors() const {
    return std::ranges::all_of(file_.volume.fields, [](const VolumeField& of) { return of.field->components() == 3; });
  }

  /// Throws Enough if a choice is needed first.
  void read() {
    const auto ask = [&](const FileContents& found) {
      file_.contents = found;
      const bool several = found.series.size() > 1 && request_.series.empty();
      if (!wanted_.is_decided && (several || !found.alternatives.empty())) throw Enough();
    };
    file_ = read_volume_file(request_, {.checksums = Checksums::later, .stop = stop_, .found = ask});
    std::optional<VolumeRequest> better = as_directions(request_, file_, {.stop = stop_});
    if (!better) better = with_vectors_joined(request_, file_.volume);
    if (!better) return;
    request_ = *better;
    file_ = read_volume_file(request_, {.checksums = Checksums::later, .stop = stop_});
  }

  LoadedScene suggested() {
    FirstSceneOptions options{.beside = beside_ ? &*beside_ : nullptr};
    for (const FilePart& label : file_.contents.labels)
      options.labels.emplace_back(label.name, static_cast<double>(label.number));
    LoadedScene made = parsed(first_scene(file_.volume, request_, options));
    const std::string name = made.scene.volumes().front().name;
    const auto is_taken = [&](const std::string& word) {
      return std::ranges::find(wanted_.taken, word) != wanted_.taken.end();
    };
    if (is_taken(name)) {
      int number = 2;
      while (is_taken(options.volume = name + "_" + std::to_string(number))) ++number;
      made = parsed(first_scene(file_.volume, request_, options));
    }
    if (beside_ && made.scene.volumes().size() == 1)
      notes_ << tr("%1 does not divide the flow from the rest: it is not used.")
                    .arg(QString::fromStdString(wanted_.beside.filename().string()));
    return made;
  }

  /// The data are loaded already: does not read them again.
  LoadedScene parsed(const std::string& text) const {
    const VolumeReader again = [&](const VolumeRequest& asked) {
      for (const Volume* whole : {&file_.volume, beside_ ? &*beside_ : nullptr}) {
        if (!whole || asked.files != whole->request->files) continue;
        if (auto part = with_fields(*whole, asked)) return *part;
      }
      return read_volume(asked, {.stop = stop_});
    };
    return parse_scene(text, title().toStdString() + " (suggested scene)", request_.files.front().parent_path(), again,
                       modes_with({}));
  }

  /// The requested fields of data in memory; none if they are not there.
  static std::optional<Volume> with_fields(const Volume& whole, const VolumeRequest& asked) {
    if (asked.fields.empty()) return whole;
    Volume part = whole;
    part.fields.clear();
    for (const VolumeRequest::FieldRequest& wanted : asked.fields) {
      const bool is_joined = !wanted.arrays.empty();
      const auto is_it = [&](const VolumeField& of) {
        return of.name == wanted.name || (!is_joined && of.name == wanted.array);
      };
      const auto found = std::ranges::find_if(whole.fields, is_it);
      if (found == whole.fields.end()) return std::nullopt;
      part.fields.push_back(*found);
      part.fields.back().name = wanted.name;
    }
    return part;
  }

  const Wanted& wanted_;
  std::stop_token stop_;
  VolumeRequest request_;
  VolumeFile file_;
  std::optional<Volume> beside_;
  QStringList notes_;
};

std::vector<std::string> words_of(const std::string& stem) {
  std::vector<std::string> words(1);
  for (const char c : stem) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  return words;
}

/// A trace, or those of a run's hands, in the order of the scene's.
Opened opened_traces(std::vector<fs::path> traces, const std::vector<fs::path>& data_folders, const ReadOptions& read) {
  const TraceReader first(traces.front());
  Opened opened{.loaded = load_recorded_scene(traces.front(), first, data_folders, read, modes_with({}), traces.size() > 1),
                .trace = traces.front()};
  const std::vector<SceneHand>& hands = opened.loaded.scene.hands();
  if (traces.size() < 2) return opened;
  for (const SceneHand& hand : hands) {
    const auto its = std::ranges::find(traces, hand.name, [](const fs::path& trace) { return trace.filename().string(); });
    if (its == traces.end())
      throw LoadError(traces.front().parent_path().string() + ": has no trace of hand " + hand.name +
                      "; open the trace of another hand alone");
    opened.hand_traces.push_back(*its);
  }
  opened.trace = opened.hand_traces.front();
  return opened;
}

}  // namespace

bool is_trace(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(traces_in(folder).front() / "trace.toml", ignored);
}

Opened open_any(const fs::path& path, const std::vector<fs::path>& data_folders, std::stop_token stop) {
  return std::move(*open_or_ask({.paths = {path}, .is_decided = true}, data_folders, stop).opened);
}

Found open_or_ask(const Wanted& wanted, const std::vector<fs::path>& data_folders, std::stop_token stop) {
  std::error_code ignored;
  for (const fs::path& path : wanted.paths) {
    if (!fs::exists(place_in_file(path).file, ignored))
      throw LoadError(path.string() + ": there is no such file or folder; check the name");
  }
  const fs::path& path = wanted.paths.front();
  const ReadOptions read{.checksums = Checksums::later, .stop = stop};
  if (is_trace(path)) {
    Opened opened = opened_traces(traces_in(path), data_folders, read);
    opened.second_trace = wanted.second_trace;
    opened.title = folder_name(path);
    return {std::move(opened), {}};
  }
  if (path.extension() == ".toml" && fs::is_regular_file(path, ignored)) {
    return {Opened{.loaded = load_scene(path, volume_reader(read), modes_with({}), {.data_folders = data_folders}),
                   .scene_file = fs::absolute(path),
                   .trace = {},
                   .title = QString::fromStdString(path.filename().string())},
            {}};
  }
  return Data(wanted, stop).opened();
}

FileContents list_parts(const fs::path& path, std::stop_token stop) {
  VolumeRequest request;
  request.files = {fs::absolute(path)};
  return list(request, stop);
}

fs::path find_beside(const fs::path& velocity) {
  constexpr std::array flows{"velocity", "velocities", "vel", "flow", "phase", "vectors", "v"};
  constexpr std::array bounds{"mask", "lumen", "segmentation", "seg", "magnitude", "mag", "signal", "anatomy", "m"};
  const auto split = [](const fs::path& path) {
    const std::string name = path.filename().string();
    const std::size_t dot = std::min(name.find('.', 1), name.size());
    return std::pair(words_of(name.substr(0, dot)), name.substr(dot));
  };
  const auto [words, ending] = split(velocity);
  fs::path best;
  std::size_t best_rank = bounds.size();
  std::error_code problem;
  for (fs::directory_iterator entry(fs::absolute(velocity).parent_path(), problem), end; !problem && entry != end;
       entry.increment(problem)) {
    const auto [others, other_ending] = split(entry->path());
    if (others.size() != words.size()) continue;
    std::size_t differences = 0, rank = bounds.size();
    for (std::size_t w = 0; w < words.size(); ++w) {
      if (words[w] == others[w]) continue;
      ++differences;
      const auto bound = std::ranges::find(bounds, others[w]);
      if (std::ranges::find(flows, words[w]) != flows.end()) rank = static_cast<std::size_t>(bound - bounds.begin());
    }
    if (differences == 1 && rank < best_rank) best = entry->path(), best_rank = rank;
  }
  return best;
}

QStringList add_to(Scene& scene, const Scene& added) {
  QStringList remarks;
  std::vector<ViewLayer> layers = detail::layers_of(scene);  // also those that no scene file names
  for (const ViewLayer& layer : detail::layers_of(added)) layers.push_back(layer);
  const Box here = scene.volumes().empty() ? Box{} : scene.volumes().front().volume.bounds_m();
  for (const SceneVolume& volume : added.volumes()) {
    const GridView* grid = grid_behind(*volume.volume.fields.front().field);
    const Box box = volume.volume.bounds_m();
    const QString name = QString::fromStdString(volume.name);
    const bool apart = box.low_m.x > here.high_m.x || box.low_m.y > here.high_m.y || box.low_m.z > here.high_m.z ||
                       box.high_m.x < here.low_m.x || box.high_m.y < here.low_m.y || box.high_m.z < here.low_m.z;
    if (apart && !scene.volumes().empty())
      remarks << tr("%1 lies beside the other data: a pose in the scene moves it.").arg(name);
    for (const SceneVolume& other : scene.volumes()) {
      const std::string &space = volume.volume.frame_of_reference, &of_other = other.volume.frame_of_reference;
      if (!space.empty() && !of_other.empty() && space != of_other)
        remarks << tr("%1 is in another frame of reference than %2: they lie together only by chance.")
                       .arg(name, QString::fromStdString(other.name));
    }
    scene.add(SceneVolume(volume), grid ? std::optional(grid->filter) : std::nullopt);
  }
  for (const SceneMode& mode : added.modes()) {
    std::string name = mode.name;
    for (int number = 2; scene.find_mode(name); ++number) name = mode.name + "_" + std::to_string(number);
    scene.add(name, mode.mode, mode.masks, mode.enabled);
  }
  scene.layers = layers;
  return remarks;
}

std::vector<fs::path> embedded_scenes() {
  std::vector<fs::path> scenes;
  try {
    for (const auto& entry : fs::directory_iterator(scenes_folder()))
      if (entry.path().filename().string().ends_with("_phantom.toml")) scenes.push_back(entry.path());
  } catch (const std::exception&) {  // the start page then has no pictures
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

}  // namespace palpa::explorer
