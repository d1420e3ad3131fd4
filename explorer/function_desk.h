// The dock in which a function of a field's values is edited: how strong or where a mode is felt, how a layer is seen.
#pragma once

#include <QDockWidget>
#include <optional>
#include <string>

#include "explorer/document.h"
#include "explorer/function_editor.h"
#include "explorer/jobs.h"

namespace palpa::explorer {

/// Knows whose the functions are that the editor shows, and brings what a person makes of them into the scene. What is felt and
/// what is seen of the same values is shown together.
class FunctionDesk : public QDockWidget {
  Q_OBJECT
 public:
  FunctionDesk(Document& document, Jobs& jobs, bool has_opengl, QWidget* parent = nullptr);

  /// \param mode  number of the scene's mode  \param row  of its parameters: a strength
  void edit_strength(std::size_t mode, std::size_t row);
  void edit_mask(std::size_t mode, std::size_t mask);
  /// \param layer  number of the layer, as they are drawn
  void edit_colors(std::size_t layer);
  /// Gives a value of the data to the nearest level of the first mode that has levels.
  void give_value_to_level(double value);
  /// The scene has changed.
  void refresh();

 Q_SIGNALS:
  void said(const QString& words, bool is_problem);

 private:
  /// A function that is felt.
  struct Felt {
    std::string mode;
    bool is_mask;
    std::size_t number;  ///< of the mode's masks, or of its parameters
  };
  void open();
  std::optional<FunctionEditor::Shown> shown() const;
  bool show_felt(const Scene& scene, FunctionEditor::Shown& shown) const;
  void choose_seen(const Scene& scene);
  void choose_felt(const Scene& scene);

  Document& document_;
  Jobs& jobs_;
  FunctionEditor* editor_;
  std::optional<Felt> felt_;
  std::optional<std::size_t> seen_;  ///< number of the layer
  bool began_with_seen_ = false;
};

}  // namespace palpa::explorer
