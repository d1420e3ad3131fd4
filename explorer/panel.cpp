#include "explorer/panel.h"

#include <QColorDialog>
#include <QEvent>
#include <QGroupBox>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QPushButton>
#include <QScrollBar>
#include <algorithm>
#include <cmath>

#include "explorer/linked_levels.h"
#include "explorer/paint.h"
#include "explorer/presets.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/parts.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace {

// Key of an undo step, equal for one row of one part: the drag of a slider is one step.
int key_of(std::size_t part, std::size_t row) { return static_cast<int>(1000 * (part + 1) + row); }

/// "surface and friction" of "surface_and_friction".
QString format_type(std::string_view type) {
  return QString::fromUtf8(type.data(), static_cast<int>(type.size())).replace('_', ' ');
}

/// Adds a mode with default inputs: fields, the first of the right kind; a level, in the middle of the values. The user sets
/// the strength.
void add_to(Scene& scene, const Mode& mode) {
  const std::string type(mode.type());
  std::string name = type;
  for (int number = 2; scene.find_mode(name); ++number) name = type + "_" + std::to_string(number);
  Mode fresh = mode;
  const Visit part = [&](ParameterVisitor& v) { fresh.visit(v); };
  const std::vector<std::string> fields = field_names(scene);
  const std::vector<ParameterRow> rows = rows_of(part);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool scalar = rows[i].info.kind == ParameterKind::scalar_field;
    if (!scalar && rows[i].info.kind != ParameterKind::vector_field) continue;
    const auto fits = [&](const std::string& field) { return (scene.field({field}).field->components() == 1) == scalar; };
    if (const auto field = std::find_if(fields.begin(), fields.end(), fits); field != fields.end())
      set_row(part, i, FieldRef{*field});
  }
  for (const ParameterListSize& list : lists_of(part))
    if (list.name == "level" && list.size == 0) append_to(part, list.name);
  const std::vector<ParameterRow> filled = rows_of(part);
  std::string field;
  for (std::size_t i = 0; i < filled.size(); ++i) {
    if (const auto* ref = std::get_if<FieldRef>(&filled[i].value); ref && field.empty()) field = ref->name;
    if (filled[i].info.kind != ParameterKind::level || field.empty()) continue;
    const ValueRange extent = scene.field({field}).field->value_ranges()[0];
    set_row(part, i, 0.5 * (extent.min + extent.max));
  }
  for (std::size_t i = 0; i < filled.size(); ++i)
    if (filled[i].info.name == "strength_n" && filled[i].group.empty() && !fresh.problem().empty())
      set_row(part, i, Strength(0.5));
  scene.add(name, fresh);
}

std::function<std::string(const std::string&)> units_of(const Scene& scene) {
  return [&scene](const std::string& field) {
    try {
      return scene.field({field}).unit;
    } catch (const std::exception&) {  // a field that is being typed
      return std::string();
    }
  };
}

/// "Only where speed > 0.1 …" of a mask.
QString words_of_mask(const Mask& mask) {
  QString name = QString::fromStdString(mask.of.name);
  if (name.startsWith("magnitude(")) name = "|" + name.mid(10).chopped(1) + "|";
  const auto& points = mask.curve.points();
  for (std::size_t i = 1; i < points.size(); ++i) {
    if ((points[i - 1].result < 0.5) == (points[i].result < 0.5)) continue;
    const double middle = 0.5 * (points[i - 1].value + points[i].value);
    return FeelPanel::tr("Only where %1 %2 %3 …").arg(name, points[i].result < 0.5 ? "<" : ">").arg(middle, 0, 'g', 3);
  }
  return FeelPanel::tr("Only where %1 …").arg(name);
}

/// The tool with the lengths that its shape has, of a usual size where there is none, and without the others.
ToolOptions with_usual_size(ToolOptions tool) {
  using Shape = ToolOptions::Shape;
  constexpr double length_m = 0.08, radius_m = 0.01;
  const bool is_round = tool.shape == Shape::pad || tool.shape == Shape::ball;
  if (tool.shape != Shape::rod) tool.length_m = 0.0;
  if (tool.shape == Shape::rod && tool.length_m == 0.0) tool.length_m = length_m;
  if (is_round && tool.radius_m == 0.0) tool.radius_m = radius_m;
  if (!is_round && tool.shape != Shape::rod) tool.radius_m = 0.0;
  if (tool.shape == Shape::points && tool.points_m.empty()) tool.points_m = {Vec3{}};
  if (tool.shape != Shape::points) tool.points_m.clear();
  return tool;
}

}  // namespace

std::vector<std::string> field_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneVolume& volume : scene.volumes()) {
    if (volume.volume.fields.size() == 1) names.push_back(volume.name);
    for (const VolumeField& field : volume.volume.fields) {
      const std::string name = volume.volume.fields.size() == 1 ? volume.name : volume.name + "." + field.name;
      if (volume.volume.fields.size() > 1) names.push_back(name);
      if (field.field->components() == 3)
        for (const char* derived : {"magnitude", "curl", "q"}) names.push_back(std::string(derived) + "(" + name + ")");
    }
  }
  return names;
}

Panel::Panel(Document& document, QWidget* parent) : QScrollArea(parent), document_(document), column_(new QVBoxLayout) {
  auto* content = new QWidget;
  content->setLayout(column_);
  column_->setContentsMargins(4, 4, 4, 4);
  setWidget(content);
  setWidgetResizable(true);
  setFrameShape(QFrame::NoFrame);
  setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  content->installEventFilter(this);
}

bool Panel::eventFilter(QObject* watched, QEvent* event) {
  // Width of the rows, which depends on the desktop's style.
  if (watched == widget() && event->type() == QEvent::LayoutRequest)
    setMinimumWidth(widget()->minimumSizeHint().width() + verticalScrollBar()->sizeHint().width());
  return QScrollArea::eventFilter(watched, event);
}

Panel::Section Panel::add_section(const QString& title) {
  Section section{new QGroupBox(title), new ParameterForm};
  auto* inside = new QVBoxLayout(section.box);
  inside->setContentsMargins(2, 2, 2, 2);
  inside->addWidget(section.form);
  column_->insertWidget(sections_at_ + static_cast<int>(sections_.size()), section.box);
  sections_.push_back(section);
  return section;
}

void Panel::remove_sections() {
  // Deferred: a section may be the sender of the current signal.
  for (const Section& section : sections_) {
    section.box->hide();
    section.box->deleteLater();
    column_->removeWidget(section.box);
  }
  sections_.clear();
}

FeelPanel::FeelPanel(Document& document, QWidget* parent)
    : Panel(document, parent), coupling_(new ParameterForm), tool_(new ParameterForm) {
  auto* firmness = new QHBoxLayout;
  struct Step {
    const char* name;
    const char* words;
    double factor;
  };
  for (const Step& step : {Step{"softer", QT_TR_NOOP("Softer"), 0.8}, Step{"firmer", QT_TR_NOOP("Firmer"), 1.25}}) {
    auto* button = new QPushButton(tr(step.words));
    button->setObjectName(step.name);
    button->setAutoRepeat(true);
    button->setToolTip(tr("Multiplies all strengths by %1").arg(step.factor));
    connect(button, &QPushButton::clicked, this, [this, factor = step.factor] { scale(factor); });
    firmness->addWidget(button);
  }
  column_->addLayout(firmness);
  sections_at_ = 1;
  auto* add = new QPushButton(tr("Add a mode"));
  add->setObjectName("add_mode");
  auto* menu = new QMenu(add);
  menu->setToolTipsVisible(true);
  connect(menu, &QMenu::aboutToShow, this, [this, menu] { list_modes(menu); });
  add->setMenu(menu);
  column_->addWidget(add);
  const auto add_group = [this](const QString& title, ParameterForm* form) {
    auto* group = new QGroupBox(title);
    auto* inside = new QVBoxLayout(group);
    inside->setContentsMargins(2, 2, 2, 2);
    inside->addWidget(form);
    column_->addWidget(group);
    return group;
  };
  add_group(tr("Coupling and force limit"), coupling_);
  add_group(tr("Tool in the hand"), tool_)->setObjectName("tool");
  column_->addStretch();
  connect(tool_, &ParameterForm::changed, this, [this](const QString& what, std::size_t row, const ParameterRow::Value& value) {
    document_.edit(what, key_of(990 + hand_, row), [&](Scene& scene) {
      ToolOptions options = scene.tool_of(hand_);
      set_row([&](ParameterVisitor& v) { visit_part(options, v); }, row, value);
      scene.set(with_usual_size(options), hand_);
    });
  });
  connect(coupling_, &ParameterForm::changed, this,
          [this](const QString& what, std::size_t row, const ParameterRow::Value& value) {
            document_.edit(what, key_of(999, row), [&](Scene& scene) {
              scene.edit<CouplingOptions>(
                  [&](auto& options) { set_row([&](ParameterVisitor& v) { visit_part(options, v); }, row, value); });
            });
          });
}

void FeelPanel::list_modes(QMenu* menu) {
  menu->clear();
  if (!document_.is_open()) return;
  int others = 0;
  const ModeCatalog modes = modes_with({});
  for (const Mode& mode : modes.modes()) {
    try {
      Scene scene = document_.scene();
      add_to(scene, mode);
      scene.check();
    } catch (const std::exception&) {
      ++others;
      continue;
    }
    const QString type = format_type(mode.type());
    QAction* action = menu->addAction(type);
    action->setToolTip(QString::fromUtf8(mode.summary().data(), static_cast<int>(mode.summary().size())));
    connect(action, &QAction::triggered, this,
            [this, mode, type] { document_.edit(tr("add %1").arg(type), -1, [&](Scene& scene) { add_to(scene, mode); }); });
  }
  if (others > 0) menu->addAction(tr("%1 more need other fields (palpa modes)").arg(others))->setEnabled(false);
}

void FeelPanel::scale(double factor) {
  document_.edit(factor > 1.0 ? tr("firmer") : tr("softer"), factor > 1.0 ? 900'010 : 900'011, [&](Scene& scene) {
    const std::vector<SceneMode> modes = scene.modes();
    for (const SceneMode& mode : modes)
      scene.edit_mode(mode.name,
                      [&](SceneMode& scaled) { scale_strengths([&](ParameterVisitor& v) { scaled.mode.visit(v); }, factor); });
  });
}

void FeelPanel::add_mask_to(std::size_t number) {
  const std::string name = document_.scene().modes()[number].name;
  const std::size_t before = document_.scene().modes()[number].masks.size();
  document_.edit(tr("add mask"), -1, [&](Scene& changed) {
    for (const std::string& field : field_names(changed)) {
      const FieldPtr found = changed.field({field}).field;
      if (found->components() != 1) continue;
      const ValueRange extent = found->value_ranges()[0];
      changed.edit_mode(name, [&](SceneMode& mode) {
        mode.masks.push_back({{field}, TransferFunction({{extent.min, 1.0}, {extent.max, 1.0}}, 1.0)});
      });
      return;
    }
    throw SceneError("mask: the scene has no scalar field; open a file that has one");
  });
  if (document_.scene().modes()[number].masks.size() > before) Q_EMIT mask_asked(number, before);
}

QPushButton* FeelPanel::mask_button(std::size_t number, std::size_t mask) {
  const SceneMode& mode = document_.scene().modes()[number];
  const QString of = QString::fromStdString(mode.masks[mask].of.name);
  auto* open = new QPushButton(words_of_mask(mode.masks[mask]));
  open->setToolTip(tr("Restricted by the value of %1").arg(of));
  open->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);  // the field's name may be long
  open->setAccessibleName(tr("Mask %1 of mode %2").arg(mask + 1).arg(QString::fromStdString(mode.name)));
  connect(open, &QPushButton::clicked, this, [this, number, mask] { Q_EMIT mask_asked(number, mask); });
  return open;
}

QHBoxLayout* FeelPanel::buttons_of(std::size_t number) {
  const SceneMode& mode = document_.scene().modes()[number];
  const std::string name = mode.name;
  const QString words = QString::fromStdString(name);
  QPixmap swatch(10, 10);
  swatch.fill(color_of_mode(number));
  auto* buttons = new QHBoxLayout;
  auto* color = new QLabel;
  color->setPixmap(swatch);
  color->setToolTip(tr("Its primitives have this colour"));
  buttons->addWidget(color);
  for (const ParameterListSize& list : lists_of([&](ParameterVisitor& v) { look_through(mode.mode, v); })) {
    const QString item = QString::fromStdString(list.name);
    auto* more = new QPushButton(tr("Add %1").arg(item));
    connect(more, &QPushButton::clicked, this, [this, name, list, item] {
      document_.edit(tr("add %1").arg(item), -1, [&](Scene& changed) {
        changed.edit_mode(name,
                          [&](SceneMode& longer) { append_to([&](ParameterVisitor& v) { longer.mode.visit(v); }, list.name); });
      });
    });
    buttons->addWidget(more);
  }
  auto* add_mask = new QToolButton;
  add_mask->setText(tr("+ condition"));
  add_mask->setToolTip(tr("Restrict the mode by a field's value"));
  add_mask->setAccessibleName(tr("Add a mask to mode %1").arg(words));
  connect(add_mask, &QToolButton::clicked, this, [this, number] { add_mask_to(number); });
  buttons->addWidget(add_mask);
  auto* remove = new QPushButton(tr("Remove"));
  remove->setAccessibleName(tr("Remove mode %1").arg(words));
  connect(remove, &QPushButton::clicked, this, [this, name, words] {
    document_.edit(tr("remove %1").arg(words), -1, [&](Scene& changed) { changed.remove_mode(name); });
  });
  buttons->addStretch();
  buttons->addWidget(remove);
  return buttons;
}

void FeelPanel::build() {
  remove_sections();
  const Scene& scene = document_.scene();
  for (std::size_t number = 0; number < scene.modes().size(); ++number) {
    const std::string name = scene.modes()[number].name;
    const QString words = QString::fromStdString(name);
    const Section section = add_section(words + "  –  " + format_type(scene.modes()[number].mode.type()));
    section.box->setCheckable(true);
    section.box->setObjectName("mode_" + words);
    section.box->setAccessibleName(tr("Mode %1, on or off").arg(words));
    connect(section.box, &QGroupBox::clicked, this, [this, name, words](bool on) {
      document_.edit(on ? tr("turn %1 on").arg(words) : tr("turn %1 off").arg(words), -1,
                     [&](Scene& changed) { changed.edit_mode(name, [&](SceneMode& mode) { mode.enabled = on; }); });
    });
    connect(section.form, &ParameterForm::changed, this,
            [this, name, number](const QString& what, std::size_t row, const ParameterRow::Value& value) {
              document_.edit(what, key_of(number, row), [&](Scene& changed) {
                changed.edit_mode(
                    name, [&](SceneMode& mode) { set_row([&](ParameterVisitor& v) { mode.mode.visit(v); }, row, value); });
              });
            });
    connect(section.form, &ParameterForm::function_asked, this,
            [this, number](std::size_t row) { Q_EMIT function_asked(number, row); });
    auto* column = static_cast<QVBoxLayout*>(section.box->layout());
    for (std::size_t mask = 0; mask < scene.modes()[number].masks.size(); ++mask) column->addWidget(mask_button(number, mask));
    column->addLayout(buttons_of(number));
  }
}

void FeelPanel::show_tool_of(std::size_t hand) {
  hand_ = hand;
  refresh();
}

void FeelPanel::refresh() {
  if (!document_.is_open()) return;
  const Scene& scene = document_.scene();
  std::vector<std::string> names;
  for (const SceneMode& mode : scene.modes())
    names.push_back(mode.name + " " + std::string(mode.mode.type()) + " " + std::to_string(mode.masks.size()));
  if (names != built_) {
    build();
    built_ = names;
  }
  const FormContext context{field_names(scene), scene.coupling().max_force_n, true, units_of(scene)};
  for (std::size_t i = 0; i < scene.modes().size(); ++i) {
    const SceneMode& mode = scene.modes()[i];
    sections_[i].box->setChecked(mode.enabled);
    sections_[i].form->show_rows(rows_of([&](ParameterVisitor& v) { look_through(mode.mode, v); }), context);
  }
  coupling_->show_rows(rows_of([&](ParameterVisitor& v) {
                         CouplingOptions copy = scene.coupling();
                         visit_part(copy, v);
                       }),
                       FormContext{{}, scene.coupling().max_force_n});
  tool_->show_rows(rows_of([&](ParameterVisitor& v) {
                     ToolOptions copy = scene.tool_of(hand_);
                     visit_part(copy, v);
                   }),
                   FormContext{{}, scene.coupling().max_force_n});
}

SeePanel::SeePanel(Document& document, QWidget* parent) : Panel(document, parent), presets_(new QComboBox) {
  presets_->setObjectName("presets");
  presets_->setAccessibleName(tr("Presets of the view"));
  presets_->addItem(tr("Presets …"));
  for (const Preset& preset : presets()) presets_->addItem(QString::fromUtf8(preset.name));
  connect(presets_, qOverload<int>(&QComboBox::activated), this, [this](int index) {
    if (index > 0) Q_EMIT preset_chosen(index - 1);
    presets_->setCurrentIndex(0);
  });
  column_->addWidget(presets_);
  sections_at_ = 1;
  connect(&document_, &Document::opened_another, this, [this] {
    hidden_.clear();
    Q_EMIT hidden_changed(hidden_);
  });
  auto* add = new QPushButton(tr("Add a layer"));
  connect(add, &QPushButton::clicked, this, [this] {
    document_.edit(tr("add layer"), -1, [](Scene& scene) {
      scene.layers = detail::layers_of(scene);
      const std::vector<std::string> fields = field_names(scene);
      if (fields.empty()) throw SceneError("view: the scene has no data to show; open a file first");
      const bool vectors = scene.field({fields.front()}).field->components() == 3;
      scene.layers.push_back(
          {.show = vectors ? ViewLayer::Show::streamlines : ViewLayer::Show::slices, .field = {fields.front()}});
    });
  });
  column_->addWidget(add);
  column_->addStretch();
}

SeePanel::SurfaceRow SeePanel::surface_row(std::size_t number) {
  SurfaceRow made;
  made.row = new QWidget;
  made.color = new QToolButton;
  made.color->setAccessibleName(tr("Colour of layer %1").arg(number + 1));
  made.color->setToolTip(tr("Colour"));
  made.opacity = new QSlider(Qt::Horizontal);
  made.opacity->setRange(0, 100);
  made.opacity->setObjectName(QString("opacity_%1").arg(number));
  made.opacity->setAccessibleName(tr("Opacity of layer %1").arg(number + 1));
  made.opacity->setToolTip(tr("Opacity"));
  made.link = new QCheckBox;
  made.link->setObjectName(QString("link_%1").arg(number));
  made.link->setToolTip(tr("Linked: felt and seen at one value"));
  connect(made.color, &QToolButton::clicked, this, [this, number] {
    const std::vector<ViewLayer> layers = detail::layers_of(document_.scene());
    const detail::SurfaceStyle look = detail::surface_style(document_.scene(), layers, number, true);
    auto* dialog = new QColorDialog(to_qt(look.color), this);
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->setWindowTitle(tr("Colour of the layer"));
    connect(dialog, &QColorDialog::colorSelected, this, [this, number](const QColor& chosen) {
      color(number, tr("colour"), [&](ViewLayer::ColorPoint& point) { point.color = chosen.name().toStdString(); });
    });
    dialog->open();
  });
  connect(made.opacity, &QSlider::valueChanged, this, [this, number](int percent) {
    color(number, tr("opacity"), [&](ViewLayer::ColorPoint& point) { point.opacity = 0.01 * percent; });
  });
  connect(made.link, &QCheckBox::clicked, this, [this, number](bool on) { link(number, on); });
  auto* looks = new QHBoxLayout;
  looks->addWidget(made.color);
  looks->addWidget(new QLabel(tr("opacity")));
  looks->addWidget(made.opacity, 1);
  auto* all = new QVBoxLayout(made.row);
  all->setContentsMargins(4, 0, 4, 0);
  all->addLayout(looks);
  all->addWidget(made.link);
  return made;
}

void SeePanel::color(std::size_t number, const QString& what, const std::function<void(ViewLayer::ColorPoint&)>& change) {
  document_.edit(what, key_of(700 + number, 0), [&](Scene& scene) {
    scene.layers = detail::layers_of(scene);
    if (number >= scene.layers.size()) return;
    const detail::SurfaceStyle look = detail::surface_style(scene, scene.layers, number, true);
    ViewLayer::ColorPoint point{look.level, to_qt(look.color).name().toStdString(), look.opacity};
    change(point);
    scene.layers[number].colors = {point};
  });
}

void SeePanel::link(std::size_t number, bool on) {
  on ? document_.loose_layers.erase(number) : document_.loose_layers.insert(number).second;
  if (on) {
    document_.edit(tr("link"), -1, [&](Scene& scene) {
      scene.layers = detail::layers_of(scene);
      if (const auto felt = level_of(scene, scene.layers.at(number))) scene.layers[number].level = felt->value;
    });
  }
  refresh();
}

void SeePanel::show_surface(std::size_t number, const std::vector<ViewLayer>& layers) {
  const SurfaceRow& row = surfaces_[number];
  const Scene& scene = document_.scene();
  row.row->setVisible(layers[number].show == ViewLayer::Show::surface);
  if (layers[number].show != ViewLayer::Show::surface) return;
  const detail::SurfaceStyle look = detail::surface_style(scene, layers, number, true);
  QPixmap swatch(16, 16);
  swatch.fill(to_qt(look.color));
  row.color->setIcon(swatch);
  const QSignalBlocker quiet(row.opacity);
  row.opacity->setValue(static_cast<int>(std::lround(100.0 * look.opacity)));
  const auto felt = level_of(scene, layers[number]);
  row.link->setVisible(felt.has_value());
  if (!felt) return;
  const bool whole = felt->value == *layers[number].level && !document_.loose_layers.contains(number);
  row.link->setChecked(whole);
  const QString name = QString::fromStdString(felt->name.empty() ? felt->mode : felt->name);
  row.link->setText(whole ? tr("linked to what is felt: %1").arg(name)
                          : tr("not linked: seen at %1, %2 felt at %3").arg(*layers[number].level).arg(name).arg(felt->value));
  row.link->setStyleSheet(whole ? "" : "QCheckBox { color: #c2410c; font-weight: bold; }");
}

void SeePanel::build(std::size_t layers) {
  remove_sections();
  surfaces_.clear();
  hidden_.clear();
  Q_EMIT hidden_changed(hidden_);
  for (std::size_t number = 0; number < layers; ++number) {
    const Section section = add_section(tr("Layer %1").arg(number + 1));
    section.box->setCheckable(true);
    section.box->setObjectName(QString("layer_%1").arg(number));
    section.box->setAccessibleName(tr("Layer %1, shown or hidden").arg(number + 1));
    connect(section.box, &QGroupBox::clicked, this, [this, number](bool on) {
      on ? hidden_.erase(number) : hidden_.insert(number).second;
      Q_EMIT hidden_changed(hidden_);
    });
    surfaces_.push_back(surface_row(number));
    section.box->layout()->addWidget(surfaces_.back().row);
    connect(section.form, &ParameterForm::changed, this,
            [this, number](const QString& what, std::size_t row, const ParameterRow::Value& value) {
              document_.edit(what, key_of(500 + number, row), [&](Scene& scene) {
                scene.layers = detail::layers_of(scene);
                if (number >= scene.layers.size()) return;
                set_row([&](ParameterVisitor& v) { visit_part(scene.layers[number], v); }, row, value);
              });
            });
    auto* buttons = new QHBoxLayout;
    auto* colors = new QPushButton(tr("Colours and opacity …"));
    connect(colors, &QPushButton::clicked, this, [this, number] { Q_EMIT colors_asked(number); });
    auto* remove = new QPushButton(tr("Remove"));
    remove->setAccessibleName(tr("Remove layer %1").arg(number + 1));
    connect(remove, &QPushButton::clicked, this, [this, number] {
      document_.edit(tr("remove layer"), -1, [&](Scene& scene) {
        scene.layers = detail::layers_of(scene);
        if (scene.layers.size() < 2) throw SceneError("view: one layer has to stay; change what it shows instead");
        scene.layers.erase(scene.layers.begin() + static_cast<std::ptrdiff_t>(number));
      });
      document_.loose_layers.clear();  // their indices have changed
    });
    buttons->addWidget(colors);
    buttons->addStretch();
    buttons->addWidget(remove);
    static_cast<QVBoxLayout*>(section.box->layout())->addLayout(buttons);
  }
  built_ = layers;
}

void SeePanel::refresh() {
  if (!document_.is_open()) return;
  const Scene& scene = document_.scene();
  const std::vector<ViewLayer> layers = detail::layers_of(scene);
  if (layers.size() != built_) build(layers.size());
  const FormContext context{field_names(scene), scene.coupling().max_force_n, false, units_of(scene)};
  for (std::size_t i = 0; i < layers.size(); ++i) {
    ViewLayer copy = layers[i];
    try {
      sections_[i].box->setTitle(QString::fromStdString(detail::layer_words(scene, layers, i)));
      show_surface(i, layers);
    } catch (const std::exception&) {  // a field that is being typed
    }
    sections_[i].box->setChecked(!hidden_.contains(i));
    sections_[i].form->show_rows(rows_of([&](ParameterVisitor& v) { visit_part(copy, v); }), context);
    if (auto* name = sections_[i].form->findChild<QLineEdit*>("name")) name->setPlaceholderText(sections_[i].box->title());
  }
}

}  // namespace palpa::explorer
