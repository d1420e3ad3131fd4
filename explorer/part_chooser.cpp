#include "explorer/part_chooser.h"

#include <QDialogButtonBox>
#include <QFormLayout>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <algorithm>

#include "palpa/base/wording.h"
#include "palpa/scene/first_volume_table.h"

namespace palpa::explorer {
namespace {

enum class Kind { series, alternatives, arrays };

Kind kind_of(const FileContents& contents) {
  if (contents.series.size() > 1) return Kind::series;
  return contents.alternatives.empty() ? Kind::arrays : Kind::alternatives;
}

QString words_of(Kind kind) {
  switch (kind) {
    case Kind::series: return PartChooser::tr("The folder holds several series. One of them is opened:");
    case Kind::alternatives: return PartChooser::tr("The file holds arrays of several shapes. One of them is opened:");
    case Kind::arrays: return PartChooser::tr("The file holds several arrays. Those with a tick are opened:");
  }
  return {};
}

QString grid_words(const FileArray& array) {
  return QString("%1 × %2 × %3").arg(array.dims[0]).arg(array.dims[1]).arg(array.dims[2]);
}

}  // namespace

PartChooser::PartChooser(const FileContents& contents, const Wanted& wanted, QWidget* parent)
    : QDialog(parent), contents_(contents), wanted_(wanted), list_(new QTreeWidget) {
  const Kind kind = kind_of(contents);
  setWindowTitle(tr("Choose what to open"));
  setObjectName("part_chooser");
  auto* all = new QVBoxLayout(this);
  all->addWidget(new QLabel(words_of(kind)));
  list_->setObjectName("parts");
  list_->setAccessibleName(tr("Parts of the file"));
  list_->setRootIsDecorated(false);
  list_->setUniformRowHeights(true);
  all->addWidget(list_, 1);
  if (kind == Kind::series) list_one(contents.series, {tr("Series"), tr("Images")});
  if (kind == Kind::alternatives) list_one(contents.alternatives, {tr("Array"), tr("Numbers")});
  if (kind == Kind::arrays) list_arrays();
  list_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  list_->header()->setStretchLastSection(false);

  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Open | QDialogButtonBox::Cancel);
  open_ = buttons->button(QDialogButtonBox::Open);
  open_->setDefault(true);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(list_, &QTreeWidget::itemSelectionChanged, this, &PartChooser::allow);
  connect(list_, &QTreeWidget::itemChanged, this, &PartChooser::allow);
  if (kind != Kind::arrays) connect(list_, &QTreeWidget::itemDoubleClicked, this, &QDialog::accept);
  all->addWidget(buttons);
  resize(560, 380);
  list_->setFocus();
  allow();
}

void PartChooser::list_one(const std::vector<FilePart>& parts, const QStringList& headings) {
  list_->setHeaderLabels(headings);
  const auto largest = std::ranges::max_element(parts, {}, &FilePart::number);
  for (const FilePart& part : parts) {
    const QString name = QString::fromStdString(part.name), words = QString::fromStdString(part.words);
    const bool is_series = !contents_.series.empty();
    const QString shown = !is_series ? name + "   (" + words + ")" : words.isEmpty() ? name : words;
    auto* item = new QTreeWidgetItem(list_, {shown, QString::number(part.number)});
    item->setTextAlignment(1, Qt::AlignRight);
    item->setToolTip(0, name);
    if (&part == &*largest) list_->setCurrentItem(item);
  }
}

void PartChooser::list_arrays() {
  list_->setHeaderLabels({tr("Array"), tr("Holds"), tr("Unit"), tr("Grid")});
  list_->setSelectionMode(QAbstractItemView::NoSelection);
  QStringList numbers;
  for (const FileArray& array : contents_.arrays) {
    const QString name = QString::fromStdString(array.name);
    const bool is_vector = array.components == 3;
    if (!is_vector) numbers << name;
    auto* item = new QTreeWidgetItem(
        list_, {name, is_vector ? tr("vectors") : tr("numbers"), QString::fromStdString(array.unit), grid_words(array)});
    item->setFlags(item->flags() | Qt::ItemIsUserCheckable);
    const auto is_asked = [&](const auto& field) { return field.array == array.name || field.name == array.name; };
    const bool is_on = wanted_.fields.empty() || std::ranges::any_of(wanted_.fields, is_asked);
    item->setCheckState(0, is_on ? Qt::Checked : Qt::Unchecked);
  }
  if (numbers.size() < 3) return;
  auto* group = new QGroupBox(tr("One vector of three arrays"));
  auto* form = new QFormLayout(group);
  vector_ = new QLineEdit("velocity");
  vector_->setObjectName("vector_name");
  form->addRow(tr("Name"), vector_);
  auto* row = new QHBoxLayout;
  const auto joined = std::ranges::find_if(wanted_.fields, [](const auto& field) { return !field.arrays.empty(); });
  for (std::size_t c = 0; c < 3; ++c) {
    auto* box = components_[c] = new QComboBox;
    box->setObjectName(QString("component_") + "xyz"[c]);
    box->setAccessibleName(tr("Component along %1").arg("xyz"[c]));
    box->addItem(tr("none"));
    box->addItems(numbers);
    if (joined != wanted_.fields.end()) box->setCurrentText(QString::fromStdString(joined->arrays[c]));
    connect(box, &QComboBox::currentTextChanged, this, &PartChooser::allow);
    row->addWidget(new QLabel(QString("xyz"[c])));
    row->addWidget(box, 1);
  }
  if (joined != wanted_.fields.end()) vector_->setText(QString::fromStdString(joined->name));
  form->addRow(tr("Components along"), row);
  layout()->addWidget(group);
}

/// The Open button works for a complete choice only.
void PartChooser::allow() {
  if (!open_) return;
  bool is_complete = false;
  if (kind_of(contents_) != Kind::arrays) {
    is_complete = list_->currentItem() != nullptr;
  } else {
    for (int n = 0; n < list_->topLevelItemCount(); ++n)
      is_complete = is_complete || list_->topLevelItem(n)->checkState(0) == Qt::Checked;
    int given = 0;
    for (const QComboBox* box : components_) given += box && box->currentIndex() > 0;
    is_complete = given == 3 || (given == 0 && is_complete);
  }
  open_->setEnabled(is_complete);
}

Wanted PartChooser::chosen() const {
  Wanted wanted = wanted_;
  wanted.is_decided = true;
  const auto number = static_cast<std::size_t>(list_->indexOfTopLevelItem(list_->currentItem()));
  switch (kind_of(contents_)) {
    case Kind::series: wanted.series = contents_.series[number].name; return wanted;
    case Kind::alternatives:
      wanted.paths = {place_in_file(wanted.paths.front()).file.string() + ":" + contents_.alternatives[number].name};
      return wanted;
    case Kind::arrays: break;
  }
  wanted.fields.clear();
  std::vector<std::string> components;
  for (const QComboBox* box : components_)
    if (box && box->currentIndex() > 0) components.push_back(box->currentText().toStdString());
  const auto add = [&](const std::string& name, const std::string& array, std::vector<std::string> arrays) {
    std::string plain = detail::plain_word(name, "array");
    while (std::ranges::any_of(wanted.fields, [&](const auto& field) { return field.name == plain; })) plain += "_";
    wanted.fields.push_back({plain, array, "", std::move(arrays)});
  };
  if (components.size() == 3) add(vector_->text().toStdString(), "", components);
  for (std::size_t n = 0; n < contents_.arrays.size(); ++n) {
    const std::string& array = contents_.arrays[n].name;
    const bool is_component = std::ranges::find(components, array) != components.end();
    if (!is_component && list_->topLevelItem(static_cast<int>(n))->checkState(0) == Qt::Checked) add(array, array, {});
  }
  return wanted;
}

}  // namespace palpa::explorer
