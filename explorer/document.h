// The open scene: text, file, undo stack.
#pragma once

#include <QObject>
#include <QStringList>
#include <QUndoStack>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "palpa/scene/load_scene.h"

namespace palpa::explorer {

/// Result of opening a scene, data or a trace.
struct Opened {
  LoadedScene loaded;
  std::filesystem::path scene_file;      ///< empty: scene suggested for data, not saved yet
  std::filesystem::path trace;           ///< empty: no trace
  std::filesystem::path second_trace{};  ///< shown beside `trace`; empty: none
  /// Of a run of several hands: the trace of each, in the scene's order, the first of them `trace`; empty: of one hand.
  std::vector<std::filesystem::path> hand_traces{};
  QString title;
  VolumeRequest request{};         ///< of data; without files: a scene or a trace
  std::filesystem::path beside{};  ///< further data that may bound the flow, not read; empty: none
  QStringList notes{};             ///< remarks on what was chosen
};

/// One scene with undo. Each step copies the scene; voxels are shared, so a step is small.
class Document : public QObject {
  Q_OBJECT
 public:
  explicit Document(QObject* parent = nullptr);

  bool is_open() const { return opened_.has_value(); }
  void open(Opened opened);
  const Scene& scene() const { return opened_->loaded.scene; }
  const Opened& opened() const { return *opened_; }
  /// Loaded scene with the current text, as a trace records it.
  LoadedScene loaded() const;

  /// Applies `change` as an undo step; consecutive steps with equal `what` and `key` merge. An invalid scene is rejected: emits
  /// `refused` with the reason and returns false.
  bool edit(const QString& what, int key, const std::function<void(Scene&)>& change);

  /// Text that `save` writes; the file's own text if the scene is unchanged.
  std::string text() const;
  /// Writes the scene. If its text has changed, the previous file is kept beside it with a `~`. Throws LoadError; nothing is
  /// lost then.
  void save(const std::filesystem::path& file);
  QUndoStack& undo() { return undo_; }
  /// Indices of surface layers whose level does not follow the felt one.
  std::set<std::size_t> loose_layers;

 Q_SIGNALS:
  void opened_another();
  void changed();
  void refused(const QString& why);

 private:
  friend class SceneStep;
  void set(const Scene& scene);

  std::optional<Opened> opened_;
  std::string saved_toml_;  // of the scene that the file's text describes
  QUndoStack undo_;
};

}  // namespace palpa::explorer
