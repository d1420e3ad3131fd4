#include "explorer/job_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QProgressBar>
#include <QToolButton>

namespace palpa::explorer {

JobBar::JobBar(Jobs& jobs) : jobs_(jobs), words_(new QLabel) {
  auto* bar = new QProgressBar;
  bar->setRange(0, 0);
  bar->setMaximumWidth(140);
  bar->setMaximumHeight(14);
  auto* cancel = new QToolButton;
  cancel->setText(tr("Cancel"));
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(words_);
  row->addWidget(bar);
  row->addWidget(cancel);
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
  setVisible(!words.isEmpty());
}

}  // namespace palpa::explorer
