// Messages in the tool bar, where they cover neither data nor controls, instead of dialogs.
#pragma once

#include <QFrame>
#include <QList>
#include <QTimer>
#include <functional>

class QHBoxLayout;
class QLabel;
class QToolButton;

namespace palpa::explorer {

/// One message at a time, its first line in at most two rows; a button opens all lines. A problem, and a message that offers
/// actions, stays until closed or replaced; others stay for their reading time, and while the mouse is over them.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  struct Offer {
    QString words;
    std::function<void()> act;
  };
  explicit MessageBar(QWidget* parent = nullptr);
  /// \param words  one line for each remark, the most important first
  void say(const QString& words, bool is_problem = false, const QList<Offer>& offers = {});
  /// All lines of the last message.
  const QString& words() const { return all_; }
  /// No higher than the buttons of the tool bar, which would move the views.
  QSize minimumSizeHint() const override { return {160, 0}; }

 protected:
  void enterEvent(QEvent* event) override;
  void leaveEvent(QEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;

 private:
  void fit();
  void show_all();

  QLabel* words_;
  QHBoxLayout* row_;
  QToolButton* more_;  ///< "2 more", "…"
  QList<QToolButton*> offers_;
  QTimer read_;
  QString all_;
  bool stays_ = false;
};

}  // namespace palpa::explorer
