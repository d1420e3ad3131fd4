#include "explorer/parameter_form.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSlider>
#include <QToolButton>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>
#include <utility>

namespace palpa::explorer {
namespace {

constexpr int slider_steps = 1000;

QString words(std::string_view text) { return QString::fromUtf8(text.data(), static_cast<int>(text.size())); }

/// Number box with as many digits as the value needs.
class NumberBox : public QDoubleSpinBox {
 public:
  NumberBox() {
    setDecimals(9);
    setKeyboardTracking(false);
    setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
    setFocusPolicy(Qt::StrongFocus);
  }
  QString textFromValue(double value) const override { return QString::number(value, 'g', 6); }
  void wheelEvent(QWheelEvent* event) override { hasFocus() ? QDoubleSpinBox::wheelEvent(event) : event->ignore(); }
};

/// End of a slider: end of the parameter's range if near, else beyond the value.
double slider_end(const ParameterInfo& info, double value, const FormContext& context) {
  if (info.kind == ParameterKind::strength) return std::max(context.largest_n, 1.5 * value);
  const double enough = std::max({3.0 * std::abs(value), info.name.ends_with("_n") ? context.largest_n : 0.0,
                                  info.name.find("ratio") != info.name.npos ? 2.0 : 0.0, 1.0});
  return std::min(info.range.high, enough);
}

}  // namespace

ParameterForm::ParameterForm(QWidget* parent) : QWidget(parent), layout_(new QFormLayout(this)) {
  layout_->setContentsMargins(4, 2, 4, 2);
  layout_->setVerticalSpacing(3);
  layout_->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
}

void ParameterForm::show_rows(const std::vector<ParameterRow>& rows, const FormContext& context) {
  std::string shape;
  for (const ParameterRow& row : rows) {
    shape += row.group + "/" + std::string(row.info.name) + std::to_string(row.value.index());
    if (const auto* strength = std::get_if<Strength>(&row.value)) shape += strength->is_constant() ? "c" : "f";
    shape += "\n";
  }
  for (const std::string& field : context.fields) shape += field + "\n";
  is_showing_ = true;
  if (shape != built_) {
    build(rows, context);
    built_ = shape;
  }
  for (std::size_t i = 0; i < rows.size(); ++i) setters_[i](rows[i].value);
  for (const auto& [group, title] : titles_) {
    std::string words = group;
    for (const ParameterRow& row : rows)
      if (const auto* name = std::get_if<std::string>(&row.value); name && row.group == group && row.info.name == "name")
        if (!name->empty()) words = *name;
    title->setText("<b>" + QString::fromStdString(words).toHtmlEscaped() + "</b>");
  }
  is_showing_ = false;
}

void ParameterForm::build(const std::vector<ParameterRow>& rows, const FormContext& context) {
  take_rows();
  for (const Row& row : rows_) {
    delete row.label;
    delete row.editor;
  }
  delete std::exchange(more_button_, nullptr);
  rows_.clear();
  setters_.clear();
  titles_.clear();
  std::size_t basic = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) basic += is_basic(rows, i);
  const bool folds = context.folds && basic > 0 && basic + 2 < rows.size();
  std::string group;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool folded = folds && !is_basic(rows, i);
    if (rows[i].group != group) {
      group = rows[i].group;
      // A row after a list belongs to the mode itself.
      auto* title = new QLabel("<b>" + tr("All levels").toHtmlEscaped() + "</b>", this);
      if (!group.empty()) titles_.emplace_back(group, title);
      rows_.push_back({title, nullptr, folded && group.empty()});
    }
    add_row(rows, i, context, folded);
  }
  if (std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.folded; })) {
    more_button_ = new QToolButton(this);
    more_button_->setCheckable(true);
    more_button_->setAutoRaise(true);
    more_button_->setObjectName("more");
    more_button_->setToolTip(tr("All parameters"));
    more_button_->setChecked(more_);
    connect(more_button_, &QToolButton::toggled, this, &ParameterForm::show_more);
  }
  show_more(more_);
}

void ParameterForm::take_rows() {
  while (layout_->rowCount() > 0) {
    const QFormLayout::TakeRowResult row = layout_->takeRow(0);
    delete row.labelItem;
    delete row.fieldItem;
  }
}

void ParameterForm::show_more(bool on) {
  more_ = on;
  take_rows();  // a hidden row would leave a gap
  for (const Row& row : rows_) {
    const bool is_shown = on || !row.folded;
    if (is_shown && row.editor) layout_->addRow(row.label, row.editor);
    if (is_shown && !row.editor) layout_->addRow(row.label);
    row.label->setVisible(is_shown);
    if (row.editor) row.editor->setVisible(is_shown);
  }
  if (!more_button_) return;
  layout_->addRow(more_button_);
  more_button_->setText(on ? tr("▾ Less") : tr("▸ More"));
}

void ParameterForm::add_row(const std::vector<ParameterRow>& rows, std::size_t number, const FormContext& context,
                            bool folded) {
  const ParameterRow& row = rows[number];
  QWidget* editor = editor_of(row, number, context);
  const NamedUnit named = named_unit(row.info.name);
  const QString named_words = QString::fromStdString(words_of_parameter(row.info.name));
  // Parameters of one name differ only in their units.
  const bool is_alone = std::count_if(rows.begin(), rows.end(), [&](const ParameterRow& other) {
                          return other.group == row.group && words_of_parameter(other.info.name) == named_words.toStdString();
                        }) == 1;
  auto* label = new QLabel(is_alone ? named_words : named_words + " / " + QString::fromStdString(named.unit), this);
  editor->setParent(this);
  for (QWidget* widget : {static_cast<QWidget*>(label), editor}) widget->setToolTip(words(row.info.sentence));
  editor->setAccessibleName((row.group.empty() ? QString() : words(row.group) + " ") + label->text());
  editor->setAccessibleDescription(words(row.info.sentence));
  label->setBuddy(editor);
  rows_.push_back({label, editor, folded});
  if (auto* box = editor->findChild<QDoubleSpinBox*>(); box && context.unit_of) {
    const auto field = std::find_if(rows.begin(), rows.end(),
                                    [](const ParameterRow& one) { return std::holds_alternative<FieldRef>(one.value); });
    const bool is_level = row.info.kind == ParameterKind::level || row.info.name == "level";
    if (is_level && field != rows.end()) {
      const std::string unit = context.unit_of(std::get<FieldRef>(field->value).name);
      if (!unit.empty()) box->setSuffix(" " + QString::fromStdString(unit));
    }
  }
}

QWidget* ParameterForm::number_editor(const ParameterRow& row, std::size_t number, double value, const FormContext& context) {
  const NamedUnit named = named_unit(row.info.name);
  auto* both = new QWidget;
  auto* line = new QHBoxLayout(both);
  line->setContentsMargins(0, 0, 0, 0);
  auto* box = new NumberBox;
  const Range& range = row.info.range;
  box->setRange(std::max(range.low, -1e9), std::min(range.high, 1e9));
  if (!named.unit.empty()) box->setSuffix(" " + QString::fromStdString(named.unit));
  box->setObjectName(QString("box_%1").arg(number));
  both->setFocusProxy(box);
  box->setMaximumWidth(92);
  line->addWidget(box, 2);
  const QString what = QString::fromStdString(named.name);
  const auto tell = [this, row, number, what](double now) {
    if (is_showing_) return;
    ParameterRow::Value changed_to = now;
    if (std::holds_alternative<std::optional<double>>(row.value)) changed_to = std::optional<double>(now);
    if (std::holds_alternative<Strength>(row.value)) changed_to = Strength(now);
    Q_EMIT changed(what, number, changed_to);
  };
  connect(box, qOverload<double>(&QDoubleSpinBox::valueChanged), this, tell);
  const bool is_level = row.info.kind == ParameterKind::level;
  if (!is_level) {
    auto* slider = new QSlider(Qt::Horizontal);
    slider->setRange(0, slider_steps);
    slider->setObjectName(QString("slider_%1").arg(number));
    slider->setAccessibleName(what);
    const double low = std::max(range.low, 0.0), high = std::max(slider_end(row.info, value, context), low + 1e-9);
    connect(slider, &QSlider::valueChanged, box, [this, box, low, high](int step) {
      if (!is_showing_) box->setValue(low + (high - low) * step / slider_steps);
    });
    connect(box, qOverload<double>(&QDoubleSpinBox::valueChanged), slider, [slider, low, high](double now) {
      const QSignalBlocker quiet(slider);
      slider->setValue(static_cast<int>(std::lround(slider_steps * std::clamp((now - low) / (high - low), 0.0, 1.0))));
    });
    line->addWidget(slider, 3);
  }
  if (row.info.kind == ParameterKind::strength) {
    auto* function = new QPushButton(tr("By value …"));
    function->setToolTip(tr("Make the strength a function of a field's value"));
    function->setAccessibleName(tr("%1 as a function of a field").arg(what));
    function->setMaximumWidth(function->fontMetrics().horizontalAdvance(function->text()) + 16);
    function->setObjectName(QString("function_%1").arg(number));
    connect(function, &QPushButton::clicked, this, [this, number] { Q_EMIT function_asked(number); });
    line->addWidget(function);
  }
  setters_.push_back([box](const ParameterRow::Value& given) {
    double now = 0.0;
    if (const auto* plain = std::get_if<double>(&given)) now = *plain;
    if (const auto* optional = std::get_if<std::optional<double>>(&given)) now = optional->value_or(0.0);
    if (const auto* strength = std::get_if<Strength>(&given)) now = strength->constant_n;
    if (box->value() != now) box->setValue(now);
    Q_EMIT box->valueChanged(box->value());  // updates the slider
  });
  return both;
}

QWidget* ParameterForm::editor_of(const ParameterRow& row, std::size_t number, const FormContext& context) {
  const QString what = QString::fromStdString(named_unit(row.info.name).name);
  if (const auto* plain = std::get_if<double>(&row.value)) return number_editor(row, number, *plain, context);
  if (const auto* strength = std::get_if<Strength>(&row.value)) {
    if (strength->is_constant()) return number_editor(row, number, strength->constant_n, context);
    auto* button = new QPushButton;
    button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);  // the field's name may be long
    button->setObjectName(QString("function_%1").arg(number));
    connect(button, &QPushButton::clicked, this, [this, number] { Q_EMIT function_asked(number); });
    setters_.push_back([button](const ParameterRow::Value& given) {
      const auto& function = std::get<Strength>(given);
      const auto& points = function.curve.points();
      const bool grows = !points.empty() && points.back().result > points.front().result;
      const bool falls = !points.empty() && points.back().result < points.front().result;
      QString name = QString::fromStdString(function.of.name);
      if (name.startsWith("magnitude(")) name = "|" + name.mid(10).chopped(1) + "|";
      button->setText((grows ? tr("Grows with %1 …") : falls ? tr("Falls with %1 …") : tr("By %1 …")).arg(name));
      button->setToolTip(tr("A function of %1 with %2 points; click to edit it")
                             .arg(QString::fromStdString(function.of.name))
                             .arg(function.curve.points().size()));
    });
    return button;
  }
  if (const auto* optional = std::get_if<std::optional<double>>(&row.value)) {
    auto* both = new QWidget;
    auto* line = new QHBoxLayout(both);
    line->setContentsMargins(0, 0, 0, 0);
    auto* given = new QCheckBox;
    given->setAccessibleName(tr("%1 is given").arg(what));
    QWidget* editor = number_editor(row, number, optional->value_or(0.0), context);
    line->addWidget(given);
    line->addWidget(editor, 1);
    const double start = std::clamp(optional->value_or(std::max(row.info.range.low, 0.0)), row.info.range.low, 1e9);
    connect(given, &QCheckBox::toggled, this, [this, number, what, start](bool on) {
      if (!is_showing_) Q_EMIT changed(what, number, on ? std::optional<double>(start) : std::optional<double>());
    });
    const auto set_number = setters_.back();
    setters_.back() = [given, editor, set_number](const ParameterRow::Value& value) {
      const bool on = std::get<std::optional<double>>(value).has_value();
      given->setChecked(on);
      editor->setEnabled(on);
      if (on) set_number(value);
    };
    both->setFocusProxy(given);
    return both;
  }
  if (std::holds_alternative<bool>(row.value)) {
    auto* box = new QCheckBox;
    connect(box, &QCheckBox::toggled, this, [this, number, what](bool on) {
      if (!is_showing_) Q_EMIT changed(what, number, on);
    });
    setters_.push_back([box](const ParameterRow::Value& value) { box->setChecked(std::get<bool>(value)); });
    return box;
  }
  if (std::holds_alternative<ParameterRow::Choice>(row.value)) {
    auto* box = new QComboBox;
    for (const std::string& choice : row.choices) box->addItem(words(words_of_choice(row.info.name, choice)));
    connect(box, qOverload<int>(&QComboBox::activated), this,
            [this, number, what](int index) { Q_EMIT changed(what, number, ParameterRow::Choice{index}); });
    setters_.push_back(
        [box](const ParameterRow::Value& value) { box->setCurrentIndex(std::get<ParameterRow::Choice>(value).index); });
    return box;
  }
  if (std::holds_alternative<FieldRef>(row.value)) {
    auto* box = new QComboBox;
    box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
    box->setMinimumContentsLength(8);
    box->setEditable(true);
    for (const std::string& field : context.fields) box->addItem(QString::fromStdString(field));
    const auto tell = [this, box, number, what] {
      if (!is_showing_) Q_EMIT changed(what, number, FieldRef{box->currentText().toStdString()});
    };
    connect(box, qOverload<int>(&QComboBox::activated), this, tell);
    connect(box->lineEdit(), &QLineEdit::editingFinished, this, tell);
    setters_.push_back(
        [box](const ParameterRow::Value& value) { box->setEditText(QString::fromStdString(std::get<FieldRef>(value).name)); });
    return box;
  }
  // Texts and lists of numbers are typed.
  auto* line = new QLineEdit;
  line->setObjectName(QString::fromUtf8(row.info.name.data(), static_cast<int>(row.info.name.size())));
  connect(line, &QLineEdit::editingFinished, this, [this, line, row, number, what] {
    if (is_showing_) return;
    if (std::holds_alternative<std::string>(row.value)) {
      // Names are plain words, in which '_' stands for a space: "inner table" is inner_table.
      const bool is_name = row.info.name == "name";
      const QString typed = is_name ? line->text().simplified().replace(' ', '_') : line->text();
      Q_EMIT changed(what, number, typed.toStdString());
    }
    if (std::holds_alternative<std::optional<std::int64_t>>(row.value)) {
      bool is_number = false;
      const qlonglong typed = line->text().toLongLong(&is_number);
      Q_EMIT changed(what, number, is_number ? std::optional<std::int64_t>(typed) : std::optional<std::int64_t>());
    }
    if (std::holds_alternative<std::vector<double>>(row.value)) {
      std::vector<double> numbers;
      for (const QString& part : line->text().split(QChar(','), Qt::SkipEmptyParts)) numbers.push_back(part.toDouble());
      Q_EMIT changed(what, number, numbers);
    }
  });
  setters_.push_back([line](const ParameterRow::Value& value) {
    QString text;
    if (const auto* plain = std::get_if<std::string>(&value)) text = QString::fromStdString(*plain);
    if (const auto* whole = std::get_if<std::optional<std::int64_t>>(&value); whole && *whole) text = QString::number(**whole);
    if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
      QStringList parts;
      for (const double n : *numbers) parts << QString::number(n, 'g', 8);
      text = parts.join(", ");
    }
    if (line->text() != text) line->setText(text);
  });
  return line;
}

}  // namespace palpa::explorer
