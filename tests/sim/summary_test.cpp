// Summaries of sweeps, their correlations against published numbers, and their plots.
#include "sim/sweep/summary.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "sim/case/case_text.h"
#include "sim/sweep/correlation.h"
#include "sim/view/plot.h"
#include "tests/temporary_folder.h"

namespace weft::sim::summary_test {

namespace {

Summary small_summary() {
  Summary summary;
  summary.factors = {"contact.friction", "time.method", "time.sleep"};
  summary.outputs = {"tip", "touch"};
  const auto add = [&](double friction, const std::string& method, bool sleep, double tip,
                       double touch, const std::string& status) {
    SummaryRow& row = summary.rows.emplace_back();
    row.hash = "hash" + std::to_string(summary.rows.size());
    row.factors = {{number_text(friction), friction},
                   {method, std::nullopt},
                   {sleep ? "true" : "false", sleep ? 1.0 : 0.0}};
    row.outputs = {tip, touch};
    row.status = status;
    row.failure = status == "done" ? "none" : "numerical";
    row.has_ended = true;
    row.version = "1.2.3";
    row.wall_time = 0.5 * static_cast<double>(summary.rows.size());
  };
  add(0.1, "cvode", true, -1, NAN, "done");
  add(0.2, "euler", true, -2, NAN, "done");
  add(0.30000000000000004, "cvode", false, -4, NAN, "done");
  add(0.4, "a, \"b\"", false, NAN, NAN, "failed");
  summary.rows[3].reason = "newton,\nagain";
  return summary;
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Summary, IsATableOfCommaSeparatedValues) {
  EXPECT_EQ(summary_csv(small_summary()),
            "run,hash,status,failure,reason,contact.friction,time.method,time.sleep,tip,touch,"
            "wall_s,cpu_s,peak_memory_mib,weft_version\n"
            "1,hash1,done,none,,0.1,cvode,true,-1,,0.500,0.000,0.000,1.2.3\n"
            "2,hash2,done,none,,0.2,euler,true,-2,,1.000,0.000,0.000,1.2.3\n"
            "3,hash3,done,none,,0.30000000000000004,cvode,false,-4,,1.500,0.000,0.000,1.2.3\n"
            "4,hash4,failed,numerical,\"newton, | again\",0.4,\"a, \"\"b\"\"\",false,,,2.000,"
            "0.000,0.000,1.2.3\n");
}

TEST(Summary, IsAnHdf5FileOfColumns) {
  const TemporaryFolder folder;
  write_summary(small_summary(), folder.path());
  const hid_t file = H5Fopen(folder.path("summary.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const auto numbers = [&](const char* name) {
    std::vector<double> values(4);
    const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
    EXPECT_GE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0)
        << name;
    H5Dclose(dataset);
    return values;
  };
  const auto texts = [&](const char* name) {
    const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
    const hid_t type = H5Dget_type(dataset);
    const std::size_t width = H5Tget_size(type);
    std::string bytes(4 * width, ' ');
    EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), 0) << name;
    std::vector<std::string> values;
    for (std::size_t i = 0; i < 4; ++i) values.emplace_back(bytes.substr(i * width, width).c_str());
    H5Tclose(type);
    H5Dclose(dataset);
    return values;
  };
  EXPECT_EQ(numbers("factors/contact.friction"),
            (std::vector<double>{0.1, 0.2, 0.30000000000000004, 0.4}));
  EXPECT_EQ(numbers("factors/time.sleep"), (std::vector<double>{1, 1, 0, 0}));
  EXPECT_EQ(texts("factors/time.method"),
            (std::vector<std::string>{"cvode", "euler", "cvode", "a, \"b\""}));
  const std::vector<double> tip = numbers("outputs/tip");
  EXPECT_EQ(tip[2], -4);
  EXPECT_TRUE(std::isnan(tip[3]));
  EXPECT_EQ(texts("status")[3], "failed");
  EXPECT_EQ(texts("hash")[1], "hash2");
  EXPECT_EQ(numbers("wall_s")[3], 2);
  H5Fclose(file);
}

TEST(Summary, HasTheSameBytesAgain) {
  const TemporaryFolder first, second;
  for (const TemporaryFolder* folder : {&first, &second}) {
    write_summary(small_summary(), folder->path());
    write_plots(small_summary(), folder->path());
  }
  // Once more over the old files.
  write_summary(small_summary(), second.path());
  write_plots(small_summary(), second.path());
  for (const char* name : {"summary.csv", "summary.h5", "correlations.csv",
                           "plots/tip-contact.friction.svg", "plots/tip-time.method.svg"}) {
    EXPECT_EQ(read_bytes(first.path(name)), read_bytes(second.path(name))) << name;
  }
}

TEST(Summary, WithoutRunsHasItsColumns) {
  const TemporaryFolder folder;
  Summary summary = small_summary();
  summary.rows.clear();
  write_summary(summary, folder.path());
  write_plots(summary, folder.path());
  EXPECT_EQ(read_bytes(folder.path("summary.csv")),
            "run,hash,status,failure,reason,contact.friction,time.method,time.sleep,tip,touch,"
            "wall_s,cpu_s,peak_memory_mib,weft_version\n");
  EXPECT_FALSE(std::filesystem::exists(folder.path("plots")));
}

TEST(Summary, SaysWhichCorrelationsAreMissing) {
  Summary summary = small_summary();
  summary.outputs.emplace_back("same");
  for (SummaryRow& row : summary.rows) row.outputs.push_back(7);
  summary.factors.emplace_back("time.duration");
  for (SummaryRow& row : summary.rows) row.factors.push_back({"2", 2.0});
  EXPECT_EQ(correlations_csv(correlations_of(summary)),
            "output,factor,runs,missing,pearson,spearman,note\n"
            "tip,contact.friction,3,1,-0.981981,-1,\n"
            "tip,time.method,3,1,,,\"the factor is a text, which has no order\"\n"
            "tip,time.sleep,3,1,0.944911,0.866025,\n"
            "tip,time.duration,3,1,,,the factor is constant\n"
            "touch,contact.friction,0,4,,,no run has a value\n"
            "touch,time.method,0,4,,,no run has a value\n"
            "touch,time.sleep,0,4,,,no run has a value\n"
            "touch,time.duration,0,4,,,no run has a value\n"
            "same,contact.friction,3,1,,,the output is constant\n"
            "same,time.method,3,1,,,\"the factor is a text, which has no order\"\n"
            "same,time.sleep,3,1,,,the output is constant\n"
            "same,time.duration,3,1,,,the output is constant\n");
}

TEST(Summary, HasAPlotOfEachOutputByEachFactor) {
  const TemporaryFolder folder;
  Plot earlier;  // of an output that is no more
  earlier.series.push_back({.name = "runs", .x = {1}, .y = {1}});
  write_svg(earlier, folder.path("plots/earlier-contact.friction.svg"));
  folder.write("plots/mine.svg", "not a plot of Weft");
  folder.write("plots/notes.txt", "not a plot");
  write_plots(small_summary(), folder.path());
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("plots")))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  EXPECT_EQ(names, (std::vector<std::string>{"mine.svg", "notes.txt", "tip-contact.friction.svg",
                                             "tip-time.method.svg", "tip-time.sleep.svg"}));
  const std::string plot = read_bytes(folder.path("plots/tip-time.method.svg"));
  EXPECT_NE(plot.find("time.method: 1 = cvode, 2 = euler"), std::string::npos) << plot;
  EXPECT_NE(plot.find("3 runs, 1 without a value; no correlation: the factor is a text"),
            std::string::npos)
      << plot;
}

// Anscombe, "Graphs in Statistical Analysis", The American Statistician 27 (1973), table: the first
// of four data sets, whose correlation is 0.816.
TEST(Correlation, OfAnscombesDataIsThePublishedOne) {
  const std::vector<double> x{10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5};
  const std::vector<double> y{8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68};
  EXPECT_NEAR(*pearson_correlation(x, y), 0.816, 5e-4);
  // The fourth: all x but one are equal.
  const std::vector<double> x4{8, 8, 8, 8, 8, 8, 8, 19, 8, 8, 8};
  const std::vector<double> y4{6.58, 5.76, 7.71, 8.84, 8.47, 7.04, 5.25, 12.50, 5.56, 7.91, 6.89};
  EXPECT_NEAR(*pearson_correlation(x4, y4), 0.817, 5e-4);
}

// Without ties, Spearman's correlation is 1 - 6 sum d^2 / (n (n^2 - 1)), with the differences d of
// the ranks.
TEST(Correlation, OfRanksIsTheClosedForm) {
  const std::vector<double> x{106, 100, 86, 101, 99, 103, 97, 113, 112, 110};
  const std::vector<double> y{7, 27, 2, 50, 28, 29, 20, 12, 6, 17};
  EXPECT_NEAR(*spearman_correlation(x, y), 1 - 6 * 194.0 / 990, 1e-14);
  // Any rising function has a correlation of ranks of 1.
  const std::vector<double> rising{1, 2, 3, 4}, steep{1, 10, 1e5, 1e300};
  EXPECT_EQ(*spearman_correlation(rising, steep), 1);
  EXPECT_LT(*pearson_correlation(rising, steep), 0.8);
}

// Equal values share the mean of their ranks: here 1, 2.5, 2.5, 4 against 1, 2, 3, 4.
TEST(Correlation, SharesTheRanksOfEqualValues) {
  const std::vector<double> x{1, 2, 2, 3}, y{1, 2, 3, 4};
  EXPECT_NEAR(*spearman_correlation(x, y), 4.5 / std::sqrt(4.5 * 5), 1e-14);
}

TEST(Correlation, OfAConstantDoesNotExist) {
  const std::vector<double> x{1, 2, 3}, same{0.1, 0.1, 0.1}, one{1};
  EXPECT_FALSE(pearson_correlation(x, same));
  EXPECT_FALSE(spearman_correlation(same, x));
  EXPECT_FALSE(pearson_correlation(one, one));
}

}  // namespace

}  // namespace weft::sim::summary_test
