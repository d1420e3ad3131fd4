#include "explorer/message_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QTextLayout>
#include <QToolButton>

namespace palpa::explorer {
namespace {

// Reading time, and per letter. Shorter: a long path cannot be read; longer: it covers the next action.
constexpr int reading_ms = 5000, letter_ms = 60;
constexpr int first_rows = 2;       // of the first line. More: a higher tool bar
constexpr int most_width_px = 640;  // of all lines
constexpr double smaller = 0.9;     // [1] size of the letters to those of the window

/// As much of a text as fits into the rows, cut with "…".
QString cut(const QString& words, const QFont& font, int width_px) {
  const QFontMetrics metrics(font);
  QTextLayout layout(words, font);
  QTextOption wrap;
  wrap.setWrapMode(QTextOption::WrapAtWordBoundaryOrAnywhere);
  layout.setTextOption(wrap);
  layout.beginLayout();
  QStringList lines;
  for (QTextLine line = layout.createLine(); line.isValid(); line = layout.createLine()) {
    line.setLineWidth(width_px);
    const int from = line.textStart();
    const bool is_last = lines.size() + 1 == first_rows;
    lines << (is_last ? metrics.elidedText(words.mid(from), Qt::ElideRight, width_px) : words.mid(from, line.textLength()));
    if (is_last) break;
  }
  layout.endLayout();
  return lines.join("\n");
}

}  // namespace

MessageBar::MessageBar(QWidget* parent)
    : QFrame(parent), words_(new QLabel), row_(new QHBoxLayout(this)), more_(new QToolButton) {
  setObjectName("message_bar");
  setAutoFillBackground(true);
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Ignored);
  words_->setTextFormat(Qt::PlainText);  // contains names of files
  words_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  words_->setAccessibleName(tr("Message"));
  words_->setObjectName("message");
  words_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Ignored);
  QFont font = words_->font();
  font.setPointSizeF(smaller * font.pointSizeF());
  words_->setFont(font);
  row_->setContentsMargins(10, 0, 4, 0);
  row_->addWidget(words_, 1);
  auto* close = new QToolButton;
  close->setText("✕");
  close->setObjectName("close_message");
  close->setAccessibleName(tr("Close message"));
  more_->setObjectName("more_message");
  more_->setAccessibleName(tr("All of the message"));
  for (QToolButton* button : {more_, close}) {
    button->setAutoRaise(true);
    row_->addWidget(button);
  }
  connect(close, &QToolButton::clicked, this, &QWidget::hide);
  connect(more_, &QToolButton::clicked, this, &MessageBar::show_all);
  read_.setSingleShot(true);
  connect(&read_, &QTimer::timeout, this, &QWidget::hide);
  hide();
}

void MessageBar::say(const QString& words, bool is_problem, const QList<Offer>& offers) {
  all_ = words;
  for (QToolButton* button : offers_) {
    button->hide();  // the sender of this call is deleted later
    button->deleteLater();
  }
  offers_.clear();
  for (const Offer& offer : offers) {
    auto* button = new QToolButton;
    button->setText(offer.words);
    connect(button, &QToolButton::clicked, this, [this, act = offer.act] {
      hide();
      act();
    });
    row_->insertWidget(row_->count() - 2, button);
    offers_.append(button);
  }
  const bool dark = parentWidget() && parentWidget()->palette().color(QPalette::Window).lightness() < 128;
  const char* const ground = is_problem ? (dark ? "#5a2117" : "#fbe3dc") : (dark ? "#1d344d" : "#e3eefb");
  const char* const ink = is_problem ? (dark ? "#ffd9cf" : "#5c1a0c") : (dark ? "#d6e7fa" : "#12304f");
  setStyleSheet(QString("QFrame#message_bar { background: %1; } QLabel, QToolButton { color: %2; }").arg(ground, ink));
  words_->setAccessibleDescription(words);
  show();
  raise();
  fit();
  stays_ = is_problem || !offers.isEmpty();
  read_.stop();
  if (!stays_) read_.start(reading_ms + letter_ms * words.size());
}

void MessageBar::fit() {
  const QStringList lines = all_.split('\n');
  more_->setText(lines.size() > 1 ? tr("%1 more").arg(lines.size() - 1) : QString("…"));
  more_->show();
  row_->activate();
  const QString shown = cut(lines.front(), words_->font(), words_->width());
  // The button of a message that fits needs no place.
  const bool is_whole = lines.size() == 1 && !shown.endsWith("…");
  more_->setVisible(!is_whole);
  words_->setText(shown);
}

void MessageBar::show_all() {
  auto* all = new QLabel(all_, this, Qt::Popup);
  all->setAttribute(Qt::WA_DeleteOnClose);
  all->setObjectName("whole_message");
  all->setTextFormat(Qt::PlainText);
  all->setWordWrap(true);
  all->setTextInteractionFlags(Qt::TextSelectableByMouse);
  all->setMargin(8);
  all->setFixedWidth(most_width_px);
  all->adjustSize();
  all->move(mapToGlobal({width() - all->width(), height()}));
  all->show();
}

void MessageBar::enterEvent(QEvent*) { read_.stop(); }

void MessageBar::leaveEvent(QEvent*) {
  if (!stays_ && isVisible()) read_.start(reading_ms);
}

void MessageBar::resizeEvent(QResizeEvent* event) {
  QFrame::resizeEvent(event);
  if (!all_.isEmpty()) fit();
}

}  // namespace palpa::explorer
