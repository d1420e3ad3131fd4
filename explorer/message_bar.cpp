#include "explorer/message_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QToolButton>

namespace palpa::explorer {
namespace {

// Reading time, and per letter. Shorter: a long path cannot be read; longer: it covers the next action.
constexpr int reading_ms = 5000, letter_ms = 60;

}  // namespace

MessageBar::MessageBar(QWidget* parent) : QFrame(parent), words_(new QLabel), row_(new QHBoxLayout(this)) {
  setObjectName("message_bar");
  setAutoFillBackground(true);
  words_->setTextFormat(Qt::PlainText);  // contains names of files
  words_->setWordWrap(true);
  words_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  words_->setAccessibleName(tr("Message"));
  words_->setObjectName("message");
  row_->setContentsMargins(10, 4, 6, 4);
  row_->addWidget(words_, 1);
  auto* close = new QToolButton;
  close->setText("✕");
  close->setObjectName("close_message");
  close->setAccessibleName(tr("Close message"));
  close->setAutoRaise(true);
  connect(close, &QToolButton::clicked, this, &QWidget::hide);
  row_->addWidget(close);
  read_.setSingleShot(true);
  connect(&read_, &QTimer::timeout, this, &QWidget::hide);
  hide();
}

void MessageBar::say(const QString& words, bool is_problem, const QList<Offer>& offers) {
  words_->setText(words);
  for (QToolButton* button : offers_) button->deleteLater();
  offers_.clear();
  for (const Offer& offer : offers) {
    auto* button = new QToolButton;
    button->setText(offer.words);
    connect(button, &QToolButton::clicked, this, [this, act = offer.act] {
      hide();
      act();
    });
    row_->insertWidget(row_->count() - 1, button);
    offers_.append(button);
  }
  const bool dark = parentWidget() && parentWidget()->palette().color(QPalette::Window).lightness() < 128;
  const char* const ground = is_problem ? (dark ? "#5a2117" : "#fbe3dc") : (dark ? "#1d344d" : "#e3eefb");
  const char* const ink = is_problem ? (dark ? "#ffd9cf" : "#5c1a0c") : (dark ? "#d6e7fa" : "#12304f");
  setStyleSheet(QString("QFrame#message_bar { background: %1; } QLabel, QToolButton { color: %2; }").arg(ground, ink));
  show();
  raise();
  stays_ = is_problem || !offers.isEmpty();
  read_.stop();
  if (!stays_) read_.start(reading_ms + letter_ms * words.size());
}

void MessageBar::enterEvent(QEvent*) { read_.stop(); }

void MessageBar::leaveEvent(QEvent*) {
  if (!stays_ && isVisible()) read_.start(reading_ms);
}

}  // namespace palpa::explorer
