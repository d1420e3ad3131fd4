#include "explorer/document.h"

#include <utility>

#include "explorer/linked_levels.h"
#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/new_file.h"

namespace palpa::explorer {

/// Undo step from one scene to the next.
class SceneStep : public QUndoCommand {
 public:
  SceneStep(Document& document, const QString& what, int key, Scene before, Scene after)
      : QUndoCommand(what), document_(document), key_(key), before_(std::move(before)), after_(std::move(after)) {}
  void undo() override { document_.set(before_); }
  void redo() override { document_.set(after_); }
  int id() const override { return key_; }
  bool mergeWith(const QUndoCommand* other) override {
    if (key_ < 0 || other->text() != text()) return false;
    after_ = static_cast<const SceneStep*>(other)->after_;
    return true;
  }

 private:
  Document& document_;
  int key_;
  Scene before_, after_;
};

Document::Document(QObject* parent) : QObject(parent) { undo_.setUndoLimit(200); }

void Document::open(Opened opened) {
  undo_.clear();
  loose_layers.clear();
  saved_toml_ = to_toml(opened.loaded.scene);
  opened_ = std::move(opened);
  Q_EMIT opened_another();
}

LoadedScene Document::loaded() const {
  LoadedScene loaded = opened_->loaded;
  loaded.text = text();
  return loaded;
}

bool Document::edit(const QString& what, int key, const std::function<void(Scene&)>& change) {
  if (!opened_) return false;
  Scene after = scene();
  try {
    change(after);
    link_levels(scene(), after, loose_layers);
    after.check();
  } catch (const std::exception& error) {
    Q_EMIT refused(QString::fromUtf8(error.what()));
    Q_EMIT changed();  // reset the forms to the valid scene
    return false;
  }
  if (!(after == scene())) undo_.push(new SceneStep(*this, what, key, scene(), std::move(after)));
  return true;
}

void Document::set(const Scene& scene) {
  opened_->loaded.scene = scene;
  Q_EMIT changed();
}

std::string Document::text() const {
  std::string toml = to_toml(scene());
  return toml == saved_toml_ ? opened_->loaded.text : toml;
}

void Document::save(const std::filesystem::path& file) {
  const std::string now = text();
  if (const detail::InputFile before(file); now != opened_->loaded.text && before.is_open())
    detail::write_whole(file.string() + "~", detail::read_whole(before, limit::scene_bytes, "save under another name"),
                        detail::Existing::replaced);
  detail::write_whole(file, now, detail::Existing::replaced);
  opened_->loaded.text = now;
  opened_->scene_file = file;
  saved_toml_ = to_toml(scene());
  undo_.setClean();
}

}  // namespace palpa::explorer
