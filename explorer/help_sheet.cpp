#include "explorer/help_sheet.h"

#include <QCoreApplication>
#include <QDesktopServices>
#include <QFileInfo>
#include <QImage>
#include <QPushButton>
#include <QTextBrowser>
#include <QVBoxLayout>

#include "palpa/base/scenes_folder.h"

namespace palpa::explorer {
namespace {

namespace fs = std::filesystem;

constexpr int most_picture_px = 720;  // of the width of a page's picture. More: a page is wider than its window

/// Text with pictures no wider than the window.
class PageText : public QTextBrowser {
 protected:
  QVariant loadResource(int type, const QUrl& name) override {
    if (type != QTextDocument::ImageResource) return QTextBrowser::loadResource(type, name);
    const QImage picture(source().resolved(name).toLocalFile());
    return picture.width() > most_picture_px ? picture.scaledToWidth(most_picture_px, Qt::SmoothTransformation) : picture;
  }
};

}  // namespace

fs::path pages_folder() {
  try {
    for (const char* way : {"../../doc/palpa/docs", "../docs"}) {
      const fs::path folder = (scenes_folder() / way).lexically_normal();
      if (fs::exists(folder / "explorer.md")) return folder;
    }
  } catch (const std::exception&) {  // no scenes: no pages beside them
  }
  return {};
}

Pages::Pages(const fs::path& page, QWidget* parent) : QDialog(parent) {
  const auto tr = [](const char* words) { return QCoreApplication::translate("Pages", words); };
  setAttribute(Qt::WA_DeleteOnClose);
  setWindowTitle(tr("Pages"));
  auto* text = new PageText;
  text->setOpenLinks(false);
  connect(text, &QTextBrowser::anchorClicked, text, [text](const QUrl& link) {
    const QUrl to = text->source().resolved(link);
    const bool is_page = to.isLocalFile() && QFileInfo(to.toLocalFile()).suffix() == "md";
    is_page ? text->setSource(to) : static_cast<void>(QDesktopServices::openUrl(to));
  });
  auto* back = new QPushButton(tr("Back"));
  back->setObjectName("back");
  back->setAutoDefault(false);
  back->setEnabled(false);
  connect(text, &QTextBrowser::backwardAvailable, back, &QWidget::setEnabled);
  connect(back, &QPushButton::clicked, text, &QTextBrowser::backward);
  auto* all = new QVBoxLayout(this);
  all->addWidget(back, 0, Qt::AlignLeft);
  all->addWidget(text);
  resize(most_picture_px + 80, 640);
  text->setSource(QUrl::fromLocalFile(QString::fromStdString(page.string())));
}

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
      {"Ctrl + drag, Ctrl + wheel", "turn the tool in the hand, also while touching"},
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
