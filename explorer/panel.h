// Side panels: parameters of modes (feel) and of layers (see).
#pragma once

#include <QCheckBox>
#include <QComboBox>
#include <QScrollArea>
#include <QSlider>
#include <QToolButton>
#include <QVBoxLayout>
#include <functional>
#include <set>
#include <vector>

#include "explorer/document.h"
#include "explorer/parameter_form.h"

class QGroupBox;
class QMenu;
class QPushButton;

namespace palpa::explorer {

/// Names of all fields of a scene.
std::vector<std::string> field_names(const Scene& scene);

/// Column of sections, one per part of the scene, each with its parameters.
class Panel : public QScrollArea {
  Q_OBJECT
 public:
  explicit Panel(Document& document, QWidget* parent = nullptr);
  /// Updates the panel from the scene.
  virtual void refresh() = 0;

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

  struct Section {
    QGroupBox* box;
    ParameterForm* form;
  };
  /// Appends a section.
  Section add_section(const QString& title);
  void remove_sections();

  Document& document_;
  QVBoxLayout* column_;
  std::vector<Section> sections_;
  int sections_at_ = 0;  // index in the column
};

/// Modes with their parameters; coupling; tool.
class FeelPanel : public Panel {
  Q_OBJECT
 public:
  explicit FeelPanel(Document& document, QWidget* parent = nullptr);
  void refresh() override;
  /// Shows the tool of this hand. \param hand  of the scene
  void show_tool_of(std::size_t hand);

 Q_SIGNALS:
  void function_asked(std::size_t mode, std::size_t row);
  void mask_asked(std::size_t mode, std::size_t mask);

 private:
  void build();
  QHBoxLayout* buttons_of(std::size_t number);
  QPushButton* mask_button(std::size_t number, std::size_t mask);
  void add_mask_to(std::size_t number);
  void list_modes(QMenu* menu);
  void scale(double factor);
  std::vector<std::string> built_;
  ParameterForm* coupling_;
  ParameterForm* tool_;
  std::size_t hand_ = 0;  ///< of the tool
};

/// Layers with their settings, each shown or hidden, its level linked to the felt one; presets.
class SeePanel : public Panel {
  Q_OBJECT
 public:
  explicit SeePanel(Document& document, QWidget* parent = nullptr);
  void refresh() override;

 Q_SIGNALS:
  void colors_asked(std::size_t layer);
  void preset_chosen(int preset);
  /// Layers that are not shown, by their indices in the scene's.
  void hidden_changed(const std::set<std::size_t>& hidden);

 private:
  /// Controls of a surface beside its parameters.
  struct SurfaceRow {
    QWidget* row = nullptr;
    QToolButton* color = nullptr;
    QSlider* opacity = nullptr;
    QCheckBox* link = nullptr;
  };
  void build(std::size_t layers);
  SurfaceRow surface_row(std::size_t number);
  void show_surface(std::size_t number, const std::vector<ViewLayer>& layers);
  void link(std::size_t number, bool on);
  void color(std::size_t number, const QString& what, const std::function<void(ViewLayer::ColorPoint&)>& change);

  QComboBox* presets_;
  std::size_t built_ = 0;
  std::vector<SurfaceRow> surfaces_;
  std::set<std::size_t> hidden_;
};

}  // namespace palpa::explorer
