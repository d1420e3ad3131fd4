#include "explorer/help_sheet.h"

#include <QCoreApplication>
#include <QTextBrowser>
#include <QVBoxLayout>

namespace palpa::explorer {

HelpSheet::HelpSheet(const QList<QAction*>& actions, QWidget* parent) : QDialog(parent) {
  const auto tr = [](const char* words) { return QCoreApplication::translate("HelpSheet", words); };
  setAttribute(Qt::WA_DeleteOnClose);
  setWindowTitle(tr("Keys and mouse"));
  struct Line {
    const char* how;
    const char* what;
  };
  static constexpr Line mouse[] = {
      {"left drag on the surface", "touch it: the hand goes where the cursor is"},
      {"left drag in a flow", "touch at the depth of the nearest line, or of the cross"},
      {"wheel while touching", "press into the surface, or less"},
      {"left drag beside it, right drag", "turn the view"},
      {"middle drag, Shift + left drag", "move the view"},
      {"wheel", "nearer and farther"},
      {"in a slice: left drag", "touch within the slice"},
      {"in a slice: right drag", "window (across) and level (up and down)"},
      {"in a slice: wheel, Ctrl + wheel", "go through the slices, nearer and farther"},
      {"Return in the scene, and again",
       "begin and end a touch by keys: the arrows lead it, Page Down presses, Page Up yields"},
      {"double click on a view", "make it large, and back"},
      {"double click in a slice while a function is edited", "give its value to the nearest level"},
  };
  QString rows;
  for (const Line& line : mouse) rows += "<tr><td><b>" + tr(line.how) + "</b></td><td>" + tr(line.what) + "</td></tr>";
  rows += "<tr><td colspan=2><br></td></tr>";
  for (const QAction* action : actions) {
    if (action->shortcut().isEmpty()) continue;
    rows += "<tr><td><b>" + action->shortcut().toString(QKeySequence::NativeText).toHtmlEscaped() + "</b></td><td>" +
            action->statusTip().toHtmlEscaped() + "</td></tr>";
  }
  auto* text = new QTextBrowser;
  text->setHtml("<table cellpadding=3>" + rows + "</table>");
  auto* all = new QVBoxLayout(this);
  all->addWidget(text);
  resize(560, 640);
}

}  // namespace palpa::explorer
