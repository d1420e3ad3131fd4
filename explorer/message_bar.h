// What the window says to a person, above its pages: nothing pops up, nothing has to be answered.
#pragma once

#include <QFrame>

class QLabel;

namespace palpa::explorer {

/// One message at a time. A problem stays until it is closed or another message comes; other words go after a while.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  explicit MessageBar(QWidget* parent = nullptr);
  void say(const QString& words, bool is_problem = false);

 private:
  QLabel* words_;
};

}  // namespace palpa::explorer
