// Form for any list of parameters: the list that scene files, `palpa modes` and the documentation share.
#pragma once

#include <QWidget>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "explorer/parameter_rows.h"

class QFormLayout;
class QLabel;
class QToolButton;

namespace palpa::explorer {

/// Fields to choose from, and the range of strengths.
struct FormContext {
  std::vector<std::string> fields;
  double largest_n = 10.0;  ///< [N] end of a strength's slider
  bool folds = false;       ///< only basic rows at first
  /// Unit of a field's values, for levels; empty: none.
  std::function<std::string(const std::string& field)> unit_of{};
};

/// One row per parameter, with unit, range and description.
class ParameterForm : public QWidget {
  Q_OBJECT
 public:
  explicit ParameterForm(QWidget* parent = nullptr);
  /// Builds the rows, or updates their values if the part has equal rows already.
  void show_rows(const std::vector<ParameterRow>& rows, const FormContext& context);

 Q_SIGNALS:
  void changed(const QString& what, std::size_t row, const palpa::explorer::ParameterRow::Value& value);
  /// Request to edit a strength as a function.
  void function_asked(std::size_t row);

 private:
  void build(const std::vector<ParameterRow>& rows, const FormContext& context);
  QWidget* editor_of(const ParameterRow& row, std::size_t number, const FormContext& context);
  QWidget* number_editor(const ParameterRow& row, std::size_t number, double value, const FormContext& context);
  QWidget* function_editor(std::size_t number);
  QWidget* optional_editor(const ParameterRow& row, std::size_t number, std::optional<double> value,
                           const FormContext& context);
  QWidget* switch_editor(const ParameterRow& row, std::size_t number);
  QWidget* choice_editor(const ParameterRow& row, std::size_t number);
  QWidget* field_editor(const ParameterRow& row, std::size_t number, const FormContext& context);
  QWidget* text_editor(const ParameterRow& row, std::size_t number);

  void add_row(const std::vector<ParameterRow>& rows, std::size_t number, const FormContext& context, bool folded);
  void show_more(bool on);
  void take_rows();

  struct Row {
    QLabel* label;
    QWidget* editor;  ///< null: a title
    bool folded;      ///< hidden until More
  };
  QFormLayout* layout_;
  std::vector<Row> rows_;
  std::vector<std::pair<std::string, QLabel*>> titles_;  ///< by group
  QToolButton* more_button_ = nullptr;                   ///< null: nothing is folded
  bool more_ = false;
  std::string built_;
  std::vector<std::function<void(const ParameterRow::Value&)>> setters_;
  bool is_showing_ = false;
};

}  // namespace palpa::explorer
