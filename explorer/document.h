// The scene that is open: its text, its file, and what can be undone.
#pragma once

#include <QObject>
#include <QUndoStack>
#include <filesystem>
#include <functional>
#include <optional>

#include "palpa/scene/load_scene.h"

namespace palpa::explorer {

/// What was opened.
struct Opened {
  LoadedScene loaded;
  std::filesystem::path scene_file;      ///< empty: the scene was suggested for data, and has no file yet
  std::filesystem::path trace;           ///< empty: no trace was opened
  std::filesystem::path second_trace{};  ///< to be shown beside it; empty: none
  QString title;
};

/// One scene, changed step by step. Each step is a scene of its own: voxels are shared, so that steps are small.
class Document : public QObject {
  Q_OBJECT
 public:
  explicit Document(QObject* parent = nullptr);

  bool is_open() const { return opened_.has_value(); }
  void open(Opened opened);
  const Scene& scene() const { return opened_->loaded.scene; }
  const Opened& opened() const { return *opened_; }
  /// As it is now, with the text that a trace of it takes.
  LoadedScene loaded() const;

  /// Changes the scene by a step that can be undone. Steps in a row with the same `what` and `key` are one. A scene that cannot
  /// be used is not taken: `refused` says why, and the answer is false.
  bool edit(const QString& what, int key, const std::function<void(Scene&)>& change);

  /// The text that `save` writes: the file's own where nothing was changed.
  std::string text() const;
  /// Writes the scene; what was in the file before stays beside it with a `~`, if it was written by somebody else. Throws
  /// LoadError: nothing is lost then.
  void save(const std::filesystem::path& file);
  QUndoStack& undo() { return undo_; }

 Q_SIGNALS:
  void opened_another();
  void changed();
  void refused(const QString& why);

 private:
  friend class SceneStep;
  void set(const Scene& scene);

  std::optional<Opened> opened_;
  std::string saved_toml_;  // of the scene whose text the file has
  QUndoStack undo_;
};

}  // namespace palpa::explorer
