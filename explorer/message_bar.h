// Messages over the window's pages, instead of dialogs.
#pragma once

#include <QFrame>
#include <QList>
#include <QTimer>
#include <functional>

class QHBoxLayout;
class QLabel;
class QToolButton;

namespace palpa::explorer {

/// One message at a time, over the picture, which does not move. A problem, and a message that offers actions, stays until
/// closed or replaced; others stay for their reading time, and while the mouse is over them.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  struct Offer {
    QString words;
    std::function<void()> act;
  };
  explicit MessageBar(QWidget* parent = nullptr);
  void say(const QString& words, bool is_problem = false, const QList<Offer>& offers = {});

 protected:
  void enterEvent(QEvent* event) override;
  void leaveEvent(QEvent* event) override;

 private:
  QLabel* words_;
  QHBoxLayout* row_;
  QList<QToolButton*> offers_;
  QTimer read_;
  bool stays_ = false;
};

}  // namespace palpa::explorer
