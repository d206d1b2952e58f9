#include "sim/sweep/summary.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

#include "sim/base/hdf5_handle.h"
#include "sim/case/case_text.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;
using hdf5::Access;
using hdf5::Handle;

// Returns a field of comma-separated values: in quotes if it has a comma, a quote or a line end.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char byte : text) {
    if (byte == '"') quoted += '"';
    quoted += byte;
  }
  return quoted + '"';
}

std::string csv_number(double value) { return std::isnan(value) ? "" : number_text(value); }

std::string three_decimals(double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3f", value);
  return buffer.data();
}

double not_a_number() { return std::numeric_limits<double>::quiet_NaN(); }

// Writes the columns of a summary as datasets of an HDF5 file.
class SummaryFile {
 public:
  // `path` names the file in messages.
  SummaryFile(const Summary& summary, const std::string& path) : summary_(summary), access_(path) {
    const Handle creation(H5Pcreate(H5P_FILE_CREATE)), access(H5Pcreate(H5P_FILE_ACCESS));
    H5Pset_obj_track_times(creation.get(), false);
    H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
    // The file stays in memory, from which bytes() copies it.
    constexpr std::size_t growth = 1 << 20;
    H5Pset_fapl_core(access.get(), growth, false);
    file_ = access_.handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                           "create it");
    write();
  }

  std::string bytes() const {
    access_.check(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), "write it");
    const ssize_t size = access_.check(H5Fget_file_image(file_.get(), nullptr, 0), "write it");
    std::string bytes(static_cast<std::size_t>(size), '\0');
    access_.check(H5Fget_file_image(file_.get(), bytes.data(), bytes.size()), "write it");
    return bytes;
  }

 private:
  void write() {
    access_.write_attribute(file_.get(), "format", "weft-summary");
    access_.write_attribute(file_.get(), "version", std::vector<int>{1});
    write_texts(file_, "hash", &SummaryRow::hash);
    write_texts(file_, "status", &SummaryRow::status);
    write_texts(file_, "failure", &SummaryRow::failure);
    write_texts(file_, "reason", &SummaryRow::reason);
    write_factors();
    const Handle outputs = make_group("outputs");
    for (std::size_t i = 0; i < summary_.outputs.size(); ++i)
      write_numbers(outputs, summary_.outputs[i], [i](const auto& row) { return row.outputs[i]; });
    write_costs("wall_s", &SummaryRow::wall_time);
    write_costs("cpu_s", &SummaryRow::cpu_time);
    write_costs("peak_memory_mib", &SummaryRow::peak_memory);
    write_texts(file_, "weft_version", &SummaryRow::version);
  }

  void write_factors() {
    const Handle group = make_group("factors");
    for (std::size_t i = 0; i < summary_.factors.size(); ++i) {
      const auto has_text = [i](const SummaryRow& row) { return !row.factors[i].number; };
      const std::string& name = summary_.factors[i];
      if (std::ranges::any_of(summary_.rows, has_text)) {
        write_texts(group, name, [i](const SummaryRow& row) { return row.factors[i].text; });
      } else {
        write_numbers(group, name, [i](const SummaryRow& row) { return *row.factors[i].number; });
      }
    }
  }

  void write_costs(const std::string& name, double SummaryRow::*cost) {
    write_numbers(file_, name, [cost](const SummaryRow& row) {
      return row.has_ended ? row.*cost : not_a_number();
    });
  }

  Handle make_group(const std::string& name) const {
    const Handle creation(H5Pcreate(H5P_GROUP_CREATE));
    H5Pset_obj_track_times(creation.get(), false);
    H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
    return access_.handle(
        H5Gcreate2(file_.get(), name.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
        "write " + name);
  }

  // Writes one value of `type` per run.
  void write_column(const Handle& parent, const std::string& name, hid_t type,
                    const void* values) const {
    const Handle creation(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_obj_track_times(creation.get(), false);
    const std::string action = "write " + name;
    const Handle space = hdf5::make_space({summary_.rows.size()});
    const Handle dataset = access_.handle(H5Dcreate2(parent.get(), name.c_str(), type, space.get(),
                                                     H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                                          action);
    if (summary_.rows.empty()) return;
    access_.check(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), action);
  }

  void write_numbers(const Handle& parent, const std::string& name, const auto& of_row) const {
    std::vector<double> values;
    for (const SummaryRow& row : summary_.rows) {
      const double value = std::invoke(of_row, row);
      values.push_back(std::isnan(value) ? not_a_number() : value);
    }
    write_column(parent, name, H5T_IEEE_F64LE, values.data());
  }

  void write_texts(const Handle& parent, const std::string& name, const auto& of_row) const {
    std::vector<std::string> texts;
    std::size_t width = 1;
    for (const SummaryRow& row : summary_.rows) {
      texts.push_back(std::invoke(of_row, row));
      width = std::max(width, texts.back().size());
    }
    std::string bytes;
    for (std::string& text : texts) {
      text.resize(width, '\0');
      bytes += text;
    }
    const Handle type(H5Tcopy(H5T_C_S1));
    H5Tset_size(type.get(), width);
    H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
    H5Tset_cset(type.get(), H5T_CSET_UTF8);
    write_column(parent, name, type.get(), bytes.data());
  }

  const Summary& summary_;
  Access access_;
  Handle file_;
};

}  // namespace

std::string summary_csv(const Summary& summary) {
  std::vector<std::string> names(first_columns.begin(), first_columns.end());
  names.insert(names.end(), summary.factors.begin(), summary.factors.end());
  names.insert(names.end(), summary.outputs.begin(), summary.outputs.end());
  names.insert(names.end(), last_columns.begin(), last_columns.end());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + csv_field(name);
  text += '\n';
  int number = 0;
  for (const SummaryRow& row : summary.rows) {
    text += std::to_string(++number);
    for (const std::string& field : {row.hash, row.status, row.failure, in_one_line(row.reason)})
      text += ',' + csv_field(field);
    for (const FactorValue& value : row.factors) text += ',' + csv_field(value.text);
    for (const double value : row.outputs) text += ',' + csv_number(value);
    for (const double cost : {row.wall_time, row.cpu_time, row.peak_memory})
      text += ',' + (row.has_ended ? three_decimals(cost) : "");
    text += ',' + (row.has_ended ? csv_field(row.version) : "") + '\n';
  }
  return text;
}

void write_summary(const Summary& summary, const fs::path& folder) {
  write_whole_file(folder / "summary.csv", summary_csv(summary));
  const hdf5::QuietErrors quiet;
  const fs::path path = folder / "summary.h5";
  write_whole_file(path, SummaryFile(summary, path.string()).bytes());
}

}  // namespace weft::sim
