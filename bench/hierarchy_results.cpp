#include "bench/hierarchy_results.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace weft::bench {

namespace {

constexpr const char* remark =
    "Peers take any mesh; Weft takes geometry images, and owes its speed to that. All find the "
    "same candidates (triangles of no common vertex whose boxes come within the margin); \"weft\" "
    "leaves out those that its tangent certificate proves to be no hits, \"weft-uncertified\" does "
    "not. Both hand their candidates to the narrow phase by pairs of leaf blocks (a mask of 64 "
    "pairs each), \"weft-listed\" writes them out one by one. Refitted trees were built at another "
    "pose a few millimetres away.";

template <class T>
nlohmann::ordered_json value_of(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  std::array<char, 256> text{};
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}

std::string column(const std::optional<double>& ms) {
  return ms ? format(" %10.3f", *ms) : format(" %10s", "-");
}

std::string column(const std::optional<long>& count) {
  return count ? format(" %10ld", *count) : format(" %10s", "-");
}

std::optional<double> smaller(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

std::optional<double> sum(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return std::nullopt;
  return *a + *b;
}

// The least times of all peers on a scene.
struct Best {
  std::optional<double> refit, rebuild, query, exact, exact_with_ours;

  void take(const Row& peer) {
    refit = smaller(refit, peer.refit_ms);
    rebuild = smaller(rebuild, peer.rebuild_ms);
    // A peer that builds its hierarchy during the query has neither time.
    const std::optional<double> made =
        peer.rebuild_ms || peer.refit_ms ? smaller(peer.rebuild_ms, peer.refit_ms) : 0.0;
    const std::optional<double> found = sum(made, peer.query_ms);
    query = smaller(query, found);
    exact = smaller(exact, sum(found, peer.narrow_ms));
    exact_with_ours = smaller(exact_with_ours, sum(found, peer.weft_narrow_ms));
  }
};

std::string ratio(const std::optional<double>& peer, const std::optional<double>& ours) {
  if (!peer || !ours) return format(" %12s", "-");
  return format(" %11.1fx", *peer / *ours);
}

std::string ratio_line(const Results& results, const Row& weft) {
  Best best;
  for (const Row& row : results.rows) {
    if (row.kind == MethodKind::peer && row.scene == weft.scene && row.n == weft.n) best.take(row);
  }
  if (!best.query) return "";
  const std::optional<double> found = sum(weft.rebuild_ms, weft.query_ms);
  const std::optional<double> exact = sum(found, weft.narrow_ms);
  return format("%-16s %5d", weft.scene.c_str(), weft.n) + ratio(best.refit, weft.rebuild_ms) +
         ratio(best.rebuild, weft.rebuild_ms) + ratio(best.query, found) +
         ratio(best.exact, exact) + ratio(best.exact_with_ours, exact) + "\n";
}

std::string ratios(const Results& results) {
  std::string lines;
  for (const Row& row : results.rows) {
    if (row.kind == MethodKind::weft && row.threads == 1) lines += ratio_line(results, row);
  }
  if (lines.empty()) return "";
  return "\nHow many times longer the best peer takes than weft, one thread each\n" +
         format("%-16s %5s %12s %12s %12s %12s %12s\n", "scene", "n", "refit", "rebuild", "+ query",
                "+ narrow", "+ our narrow") +
         lines;
}

// Returns the table of Weft's rebuild times by size, against the floor.
std::string floor_lines(const Results& results) {
  std::string lines;
  for (const Row& row : results.rows) {
    if (row.method != "copy") continue;
    const auto weft = std::find_if(results.rows.begin(), results.rows.end(), [&](const Row& other) {
      return other.scene == row.scene && other.n == row.n && other.kind == MethodKind::weft;
    });
    lines += format("%6d %12.3f %12.3f %12.2f %16.2f\n", row.n, *row.rebuild_ms, *weft->rebuild_ms,
                    *weft->rebuild_ms / *row.rebuild_ms,
                    1e6 * *weft->rebuild_ms / (static_cast<double>(row.n) * row.n));
  }
  if (lines.empty()) return "";
  return "\nRebuild against a copy that reads the image's bytes and writes the hierarchy's\n" +
         format("%6s %12s %12s %12s %16s\n", "n", "copy ms", "rebuild ms", "ratio", "ns a vertex") +
         lines +
         format("hierarchy at n = %d: %.2f MB\n", results.floor_n,
                1e-6 * static_cast<double>(results.hierarchy_bytes));
}

}  // namespace

std::string to_json(const Results& results) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Row& row : results.rows) {
    rows.push_back({{"scene", row.scene},
                    {"n", row.n},
                    {"method", row.method},
                    {"threads", row.threads},
                    {"rebuild_ms", value_of(row.rebuild_ms)},
                    {"refit_ms", value_of(row.refit_ms)},
                    {"query_ms", value_of(row.query_ms)},
                    {"narrow_ms", value_of(row.narrow_ms)},
                    {"weft_narrow_ms", value_of(row.weft_narrow_ms)},
                    {"candidates", value_of(row.candidates)},
                    {"hits", value_of(row.hits)}});
  }
  const nlohmann::ordered_json document{{"rows", rows},
                                        {"floor_ms", results.floor_ms},
                                        {"floor_n", results.floor_n},
                                        {"hierarchy_bytes", results.hierarchy_bytes},
                                        {"remark", remark}};
  return document.dump(1) + "\n";
}

std::string to_table(const Results& results) {
  std::string text =
      std::string(remark) + "\n\n" +
      format("%-16s %5s %-24s %3s %10s %10s %10s %10s %10s %10s %10s\n", "scene", "n", "method",
             "thr", "rebuild", "refit", "query", "narrow", "our narrow", "candidates", "hits");
  for (const Row& row : results.rows) {
    text +=
        format("%-16s %5d %-24s %3d", row.scene.c_str(), row.n, row.method.c_str(), row.threads) +
        column(row.rebuild_ms) + column(row.refit_ms) + column(row.query_ms) +
        column(row.narrow_ms) + column(row.weft_narrow_ms) + column(row.candidates) +
        column(row.hits) + "\n";
  }
  return text + ratios(results) + floor_lines(results);
}

}  // namespace weft::bench
