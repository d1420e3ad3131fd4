#include "explorer/start_page.h"

#include <QDir>
#include <QFileInfo>
#include <QFrame>
#include <QHBoxLayout>
#include <QKeyEvent>
#include <QLabel>
#include <QPushButton>
#include <QToolButton>
#include <QVBoxLayout>

#include "explorer/opening.h"
#include "explorer/settings.h"
#include "palpa/version.h"

namespace palpa::explorer {
namespace {

struct Known {
  const char* file;
  const char* title;
  const char* words;
};
constexpr Known known[] = {
    {"head_phantom.toml", QT_TR_NOOP("A head"), QT_TR_NOOP("skin gives, bone stops")},
    {"flow_phantom.toml", QT_TR_NOOP("Blood in a chamber"), QT_TR_NOOP("it carries the hand along")},
    {"wing_phantom.toml", QT_TR_NOOP("A wing's wake"), QT_TR_NOOP("vortices that turn it")},
    {"beat_phantom.toml", QT_TR_NOOP("A beating heart"), QT_TR_NOOP("data that move under it")},
};

QToolButton* tile(const QString& file, const QString& title, const QString& words) {
  auto* button = new QToolButton;
  QFileInfo info(file);
  QPixmap picture(info.absolutePath() + "/pictures/" + info.completeBaseName() + ".png");
  button->setToolButtonStyle(Qt::ToolButtonTextUnderIcon);
  if (!picture.isNull()) button->setIcon(QIcon(picture));
  button->setIconSize({264, 198});
  button->setText(title + "\n" + words);
  button->setAccessibleName(title);
  button->setMinimumSize(280, 256);
  button->setObjectName("tile_" + info.completeBaseName());
  button->setAutoRaise(true);
  return button;
}

}  // namespace

StartPage::StartPage(QWidget* parent) : QWidget(parent), recent_(new QVBoxLayout) {
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(40, 28, 40, 28);
  all->setSpacing(18);
  auto* title = new QLabel(tr("Touch volumetric data"));
  QFont large = title->font();
  large.setPointSizeF(1.9 * large.pointSizeF());
  title->setFont(large);
  all->addWidget(title);

  auto* row = new QHBoxLayout;
  row->setSpacing(16);
  const std::vector<std::filesystem::path> scenes = embedded_scenes();
  for (const Known& one : known) {
    for (const std::filesystem::path& scene : scenes) {
      if (scene.filename() != one.file) continue;
      const QString file = QString::fromStdString(scene.string());
      QToolButton* button = tile(file, tr(one.title), tr(one.words));
      connect(button, &QToolButton::clicked, this, [this, file] { Q_EMIT chosen(file); });
      row->addWidget(button);
    }
  }
  row->addStretch();
  all->addLayout(row);

  auto* area = new QFrame;
  area->setObjectName("drop_area");
  area->setStyleSheet("QFrame#drop_area { border: 2px dashed palette(mid); border-radius: 8px; }");
  auto* drop = new QVBoxLayout(area);
  drop->setContentsMargins(24, 20, 24, 20);
  auto* invitation = new QLabel(tr("Drop a scan, a simulation, a scene or a recording here"));
  QFont larger = invitation->font();
  larger.setPointSizeF(1.2 * larger.pointSizeF());
  invitation->setFont(larger);
  auto* kinds = new QLabel(tr("NRRD, NIfTI, DICOM, MetaImage, VTK, HDF5, OpenFOAM, PLOT3D, a scene.toml, a trace"));
  auto* open = new QPushButton(tr("Open a file …"));
  open->setObjectName("open_file");
  open->setToolTip(tr("Ctrl+O"));
  connect(open, &QPushButton::clicked, this, [this] { Q_EMIT open_asked(); });
  auto* folder = new QPushButton(tr("Open a folder …"));
  folder->setObjectName("open_folder");
  folder->setToolTip(tr("Ctrl+Shift+O: a DICOM series, an OpenFOAM case, a trace"));
  connect(folder, &QPushButton::clicked, this, [this] { Q_EMIT folder_asked(); });
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(open);
  buttons->addWidget(folder);
  drop->addWidget(invitation, 0, Qt::AlignHCenter);
  drop->addWidget(kinds, 0, Qt::AlignHCenter);
  drop->addLayout(buttons);
  drop->setAlignment(buttons, Qt::AlignHCenter);
  all->addWidget(area);

  recent_->setSpacing(2);
  all->addLayout(recent_);
  all->addStretch();
  auto* about = new QLabel(tr("Palpa %1").arg(version));
  about->setEnabled(false);
  all->addWidget(about, 0, Qt::AlignRight);
}

// Space turns the force off everywhere, so Return presses the button with the focus.
void StartPage::keyPressEvent(QKeyEvent* event) {
  auto* const button = qobject_cast<QAbstractButton*>(focusWidget());
  if (button && (event->key() == Qt::Key_Return || event->key() == Qt::Key_Enter)) return button->click();
  QWidget::keyPressEvent(event);
}

void StartPage::show_recent(const QStringList& files) {
  while (QLayoutItem* item = recent_->takeAt(0)) {
    if (QWidget* widget = item->widget()) widget->deleteLater();
    delete item;
  }
  const auto is_recording = [](const QString& file) { return is_trace(file.toStdString()); };
  for (const bool recordings : {false, true}) {
    QLabel* title = nullptr;
    for (const QString& file : files) {
      if (is_recording(file) != recordings) continue;
      if (!title)
        recent_->addWidget(title = new QLabel("<b>" + (recordings ? tr("My recordings") : tr("Recent files")) + "</b>"));
      add_recent(file);
    }
  }
}

void StartPage::add_recent(const QString& file) {
  const QFileInfo info(file);
  auto* button = new QPushButton(words_of_recent(file) + "   –   " + QDir::toNativeSeparators(info.path()));
  button->setToolTip(file);
  button->setFlat(true);
  button->setStyleSheet("text-align: left");
  connect(button, &QPushButton::clicked, this, [this, file] { Q_EMIT chosen(file); });
  recent_->addWidget(button, 0, Qt::AlignLeft);
}

}  // namespace palpa::explorer
