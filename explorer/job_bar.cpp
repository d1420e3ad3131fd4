#include "explorer/job_bar.h"

#include <QGridLayout>
#include <QLabel>
#include <QProgressBar>
#include <QToolButton>

namespace palpa::explorer {

JobBar::JobBar(Jobs& jobs, Shown shown) : jobs_(jobs), shown_(shown), words_(new QLabel) {
  auto* bar = new QProgressBar;
  bar->setRange(0, 0);
  auto* cancel = new QToolButton;
  cancel->setText(tr("Cancel"));
  cancel->setObjectName("cancel_job");
  auto* grid = new QGridLayout(this);
  if (shown == Shown::reading) {
    setObjectName("reading");
    setAutoFillBackground(true);
    setFrameShape(QFrame::StyledPanel);
    QFont large = words_->font();
    large.setPointSizeF(1.3 * large.pointSizeF());
    words_->setFont(large);
    grid->setContentsMargins(28, 20, 28, 20);
    grid->setVerticalSpacing(12);
    bar->setMinimumWidth(320);
    grid->addWidget(words_, 0, 0, 1, 2, Qt::AlignHCenter);
    grid->addWidget(bar, 1, 0);
    grid->addWidget(cancel, 1, 1);
  } else {
    bar->setMaximumSize(140, 14);
    grid->setContentsMargins(0, 0, 0, 0);
    grid->addWidget(words_, 0, 0);
    grid->addWidget(bar, 0, 1);
    grid->addWidget(cancel, 0, 2);
  }
  connect(cancel, &QToolButton::clicked, this, [this] {
    jobs_.cancel_all();
    Q_EMIT cancelled();
  });
  connect(&jobs_, &Jobs::changed, this, &JobBar::show_job);
  show_job();
}

void JobBar::show_job() {
  const QString words = jobs_.words();
  words_->setText(words);
  setVisible(!words.isEmpty() && jobs_.is_under_way(Jobs::Purpose::open) == (shown_ == Shown::reading));
  if (isVisible() && shown_ == Shown::reading) raise();
}

}  // namespace palpa::explorer
