#include "explorer/message_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QTimer>
#include <QToolButton>

namespace palpa::explorer {
namespace {

constexpr int reading_ms = 8000;  // shorter: a long path cannot be read; longer: stays during the next action

}  // namespace

MessageBar::MessageBar(QWidget* parent) : QFrame(parent), words_(new QLabel) {
  setObjectName("message_bar");
  words_->setTextFormat(Qt::PlainText);  // contains names of files
  words_->setWordWrap(true);
  words_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  words_->setAccessibleName(tr("Message"));
  words_->setObjectName("message");
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(10, 4, 6, 4);
  row->addWidget(words_, 1);
  auto* close = new QToolButton;
  close->setText("✕");
  close->setAccessibleName(tr("Close message"));
  close->setAutoRaise(true);
  connect(close, &QToolButton::clicked, this, &QWidget::hide);
  row->addWidget(close);
  hide();
}

void MessageBar::say(const QString& words, bool is_problem) {
  words_->setText(words);
  setStyleSheet(is_problem ? "QFrame#message_bar { background: #fbe3dc; } QLabel, QToolButton { color: #5c1a0c; }"
                           : "QFrame#message_bar { background: #e3eefb; } QLabel, QToolButton { color: #12304f; }");
  show();
  if (is_problem) return;
  QTimer::singleShot(reading_ms, this, [this, words] {
    if (words_->text() == words) hide();
  });
}

}  // namespace palpa::explorer
