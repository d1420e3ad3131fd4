// Dock for editing a function of a field's values: strength or mask of a mode, colours of a layer.
#pragma once

#include <QDockWidget>
#include <optional>
#include <string>

#include "explorer/document.h"
#include "explorer/function_editor.h"
#include "explorer/jobs.h"

namespace palpa::explorer {

/// Maps the functions in the editor to modes and layers, and applies edits to the scene. Strength and colours of one field are
/// shown together.
class FunctionDesk : public QDockWidget {
  Q_OBJECT
 public:
  FunctionDesk(Document& document, Jobs& jobs, bool has_opengl, QWidget* parent = nullptr);

  /// \param mode  index in the scene  \param row  index of a strength among the mode's parameters
  void edit_strength(std::size_t mode, std::size_t row);
  void edit_mask(std::size_t mode, std::size_t mask);
  /// \param layer  index in drawing order
  void edit_colors(std::size_t layer);
  /// Sets the nearest level of the first mode that has levels.
  void give_value_to_level(double value);
  /// To be called after each change of the scene.
  void refresh();

 Q_SIGNALS:
  void said(const QString& words, bool is_problem);

 private:
  /// Strength or mask of a mode.
  struct Felt {
    std::string mode;
    bool is_mask;
    std::size_t number;  ///< index among the mode's masks or parameters
  };
  void open();
  void open(const Felt& felt);
  /// Opens a strength that is a number as a function, constant over the values of a field.
  void draft(const Felt& felt, const std::string& field, const ValueRange& values);
  std::optional<FunctionEditor::Shown> shown() const;
  bool show_felt(const Scene& scene, FunctionEditor::Shown& shown) const;
  void choose_seen(const Scene& scene);
  void choose_felt(const Scene& scene);

  Document& document_;
  Jobs& jobs_;
  FunctionEditor* editor_;
  std::optional<Felt> felt_;
  std::optional<Strength> draft_;    ///< of `felt_`, a constant strength as a function; in the scene from its first edit on
  std::optional<std::size_t> seen_;  ///< index of the layer
  bool began_with_seen_ = false;
};

}  // namespace palpa::explorer
