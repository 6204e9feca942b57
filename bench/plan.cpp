// A* of the library beside a plain one, on the same queries in the same run, in turns.
// Rivals: the A* of textbooks (std::priority_queue, std::unordered_map), and the same with flat
// arrays in place of the hash map. Same heuristic, same rules, and equal costs are checked.
//   plan [--json] [--repetitions N]
// Times are of one query in milliseconds: the mean over the queries of a case, and of that the
// median over the repetitions.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <queue>
#include <random>
#include <sstream>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "times.hpp"
#include "tread/plan/a_star.hpp"
#include "tread/plan/planner.hpp"

namespace {

namespace fs = std::filesystem;
using tread::Cell;
using tread::Grid;
using tread::GridSearchOptions;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Query {
  Cell start;
  Cell goal;
};

struct Case {
  std::string name;
  Grid<float> grid;
  std::vector<Query> queries;
};

// What a search knows about each cell, by number of the cell.
struct HashedKnowledge {
  std::unordered_map<int, double> g;
  std::unordered_map<int, int> parent;
  explicit HashedKnowledge(std::size_t) {}
  [[nodiscard]] double cost(int cell) const {
    const auto found = g.find(cell);
    return found == g.end() ? kInfinity : found->second;
  }
};

struct FlatKnowledge {
  std::vector<double> g;
  std::vector<int> parent;
  explicit FlatKnowledge(std::size_t cells) : g(cells, kInfinity), parent(cells, -1) {}
  [[nodiscard]] double cost(int cell) const { return g[static_cast<std::size_t>(cell)]; }
};

template <class Container>
auto& at(Container& container, int cell) {
  return container[static_cast<typename Container::size_type>(cell)];
}
template <class Value>
Value& at(std::unordered_map<int, Value>& container, int cell) {
  return container[cell];
}

template <class Knowledge>
class PlainAStar {
 public:
  PlainAStar(const Grid<float>& grid, const GridSearchOptions& options)
      : grid_(grid), options_(options), columns_(grid.geometry.columns) {
    for (const float value : grid.values) {
      if (cost_of(value) < kInfinity) smallest_ = std::min(smallest_, cost_of(value));
    }
  }

  tread::GridPath search(Cell start, Cell goal) {
    Knowledge known(grid_.values.size());
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    at(known.g, number(start)) = 0.0;
    open.push({estimate(start, goal), number(start), 0.0});
    tread::GridPath path;
    while (!open.empty()) {
      const Entry entry = open.top();
      open.pop();
      if (entry.g > known.cost(entry.cell)) continue;
      ++path.expanded;
      if (entry.cell == number(goal)) return finished(known, start, goal, path);
      const Cell c{entry.cell % columns_, entry.cell / columns_};
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const double step = (dx == 0 && dy == 0) ? kInfinity : step_cost(c, dx, dy);
          if (step == kInfinity) continue;
          const Cell next{c.x + dx, c.y + dy};
          const double g = entry.g + step;
          if (g >= known.cost(number(next))) continue;
          at(known.g, number(next)) = g;
          at(known.parent, number(next)) = entry.cell;
          open.push({g + estimate(next, goal), number(next), g});
        }
      }
    }
    return path;
  }

 private:
  struct Entry {
    double f;
    int cell;
    double g;
    auto operator<=>(const Entry&) const = default;
  };

  [[nodiscard]] double cost_of(float value) const {
    const double cost = std::isnan(value) ? options_.unexplored_cost : double{value};
    return cost < options_.lethal_cost ? std::max(cost, double{tread::kSmallestCost}) : kInfinity;
  }
  [[nodiscard]] double cost_at(Cell c) const {
    return grid_.geometry.contains(c) ? cost_of(grid_[c]) : kInfinity;
  }
  [[nodiscard]] int number(Cell c) const { return c.y * columns_ + c.x; }
  [[nodiscard]] double step_cost(Cell c, int dx, int dy) const {
    const double to = cost_at({c.x + dx, c.y + dy});
    if (to == kInfinity) return kInfinity;
    const double length = dx != 0 && dy != 0 ? std::numbers::sqrt2 : 1.0;
    if (dx != 0 && dy != 0 &&
        (cost_at({c.x + dx, c.y}) == kInfinity || cost_at({c.x, c.y + dy}) == kInfinity)) {
      return kInfinity;
    }
    return length * grid_.geometry.resolution_m * 0.5 * (cost_at(c) + to);
  }
  [[nodiscard]] double estimate(Cell c, Cell goal) const {
    const int dx = std::abs(c.x - goal.x);
    const int dy = std::abs(c.y - goal.y);
    return smallest_ * grid_.geometry.resolution_m *
           (std::max(dx, dy) + (std::numbers::sqrt2 - 1.0) * std::min(dx, dy));
  }
  tread::GridPath finished(Knowledge& known, Cell start, Cell goal, tread::GridPath path) const {
    path.found = true;
    path.cost = known.cost(number(goal));
    for (int cell = number(goal); cell != number(start); cell = at(known.parent, cell)) {
      path.cells.push_back({cell % columns_, cell / columns_});
    }
    path.cells.push_back(start);
    std::reverse(path.cells.begin(), path.cells.end());
    return path;
  }

  const Grid<float>& grid_;
  GridSearchOptions options_;
  int columns_;
  double smallest_ = kInfinity;
};

// Smooth random costs: white noise, blurred three times by a box, scaled to 1 .. 60, so that the
// peaks are obstacles; seeded and the same everywhere.
Grid<float> smooth_map(int size, unsigned seed) {
  constexpr int kRadius = 7;
  std::mt19937 random(seed);
  const auto n = static_cast<std::size_t>(size);
  std::vector<double> values(n * n);
  for (double& v : values) v = static_cast<double>(random() % 65536);
  for (int pass = 0; pass < 6; ++pass) {  // rows and columns in turn
    const std::size_t along = pass % 2 == 0 ? 1 : n;
    const std::size_t across = pass % 2 == 0 ? n : 1;
    std::vector<double> blurred(n * n);
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < size; ++i) {
        double sum = 0.0;
        for (int k = -kRadius; k <= kRadius; ++k) {
          const auto wrapped = static_cast<std::size_t>((i + k + size) % size);
          sum += values[static_cast<std::size_t>(j) * across + wrapped * along];
        }
        blurred[static_cast<std::size_t>(j) * across + static_cast<std::size_t>(i) * along] = sum;
      }
    }
    values = std::move(blurred);
  }
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double bottom = *low;
  const double span = *high - bottom;
  Grid<float> grid(tread::GridGeometry{0.3, Eigen::Vector2d::Zero(), size, size});
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double u = (values[i] - bottom) / span;
    grid.values[i] = static_cast<float>(1.0 + 59.0 * u * u);
  }
  return grid;
}

Case smooth_case() {
  Case result{"smooth costs 512x512", smooth_map(512, 1), {}};
  std::mt19937 random(2);
  const auto free_near = [&](int x, int y) {
    for (;; x = (x + 1) % 512) {
      if (result.grid[{x, y}] < 40.0F) return Cell{x, y};
    }
  };
  result.queries.push_back({free_near(1, 1), free_near(500, 510)});
  result.queries.push_back({free_near(500, 1), free_near(1, 510)});
  while (result.queries.size() < 12) {
    const auto any = [&] { return static_cast<int>(random() % 512); };
    const Query query{free_near(any(), any()), free_near(any(), any())};
    result.queries.push_back(query);
  }
  return result;
}

// Ground seen along a winding way, obstacles here and there, the rest unexplored: what a robot's
// map looks like. Costs 1 (seen), 5 (unexplored).
Case seen_track_case() {
  Case result{
      "seen track 512x512", Grid<float>(tread::GridGeometry{0.3, {0.0, 0.0}, 512, 512}), {}};
  std::mt19937 random(3);
  for (float& v : result.grid.values) v = std::numeric_limits<float>::quiet_NaN();
  for (int x = 0; x < 512; ++x) {
    const int middle = 256 + static_cast<int>(150.0 * std::sin(x / 60.0));
    for (int y = middle - 20; y <= middle + 20; ++y) {
      result.grid[{x, y}] = 1.0F + static_cast<float>(random() % 100) / 50.0F;
    }
  }
  for (int k = 0; k < 300; ++k) {
    const int x = 10 + static_cast<int>(random() % 490);
    const int y = 10 + static_cast<int>(random() % 490);
    for (int v = y; v < y + 8; ++v) {
      for (int u = x; u < x + 8; ++u) result.grid[{u, v}] = 100.0F;
    }
  }
  for (const int y : {4, 130, 256, 380, 508}) result.queries.push_back({{3, 256}, {508, y}});
  return result;
}

fs::path data_folder() {
  const char* chosen = std::getenv("TREAD_DATA");
  const fs::path root =
      chosen != nullptr ? fs::path(chosen) : fs::path(TREAD_SOURCE_DIR) / ".." / "shared" / "data";
  return root / "movingai";
}

// At most `count` queries, evenly spread over the file, which is sorted by length.
bool read_case(const std::string& name, std::size_t count, Case& result) {
  std::ifstream map(data_folder() / (name + ".map"));
  std::ifstream scenarios(data_folder() / (name + ".map.scen"));
  std::string word;
  int rows = 0;
  int columns = 0;
  map >> word >> word >> word >> rows >> word >> columns >> word;
  if (!map || !scenarios || rows <= 0 || columns <= 0) return false;
  result.name = fmt::format("{} {}x{}", name, columns, rows);
  result.grid = Grid<float>(tread::GridGeometry{1.0, {0.0, 0.0}, columns, rows}, 1.0F);
  for (int y = 0; y < rows; ++y) {
    if (!(map >> word) || word.size() != static_cast<std::size_t>(columns)) return false;
    for (int x = 0; x < columns; ++x) {
      const char c = word[static_cast<std::size_t>(x)];
      if (c != '.' && c != 'G') result.grid[{x, y}] = 100.0F;
    }
  }
  std::vector<Query> all;
  std::string line;
  std::getline(scenarios, line);
  while (std::getline(scenarios, line)) {
    std::istringstream words(line);
    Query q;
    words >> word >> word >> word >> word >> q.start.x >> q.start.y >> q.goal.x >> q.goal.y;
    if (words) all.push_back(q);
  }
  for (std::size_t i = 0; i < count && !all.empty(); ++i) {
    result.queries.push_back(all[i * all.size() / count]);
  }
  return !result.queries.empty();
}

double milliseconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

struct Row {
  std::string name;
  std::size_t queries = 0;
  double ours_ms = 0.0;
  double longest_ms = 0.0;  // of our queries
  double hashed_ms = 0.0;
  double flat_ms = 0.0;
  double waypoints_ms = 0.0;  // plan_waypoints, search included
  double expanded = 0.0;      // mean
  double plain_expanded = 0.0;
  double cost_difference = 0.0;  // largest relative one
};

Row measure(const Case& c, int repetitions) {
  const GridSearchOptions options;
  PlainAStar<HashedKnowledge> hashed(c.grid, options);
  PlainAStar<FlatKnowledge> flat(c.grid, options);
  Row row{c.name, c.queries.size()};
  const auto n = static_cast<double>(c.queries.size());
  std::vector<double> times[4];
  std::vector<std::vector<double>> ours_by_query(c.queries.size());
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    double sums[4] = {0.0, 0.0, 0.0, 0.0};
    for (std::size_t i = 0; i < c.queries.size(); ++i) {
      const Query& q = c.queries[i];
      tread::GridPath paths[3];
      const auto run = [&](int which) {
        const double ms = milliseconds([&] {
          if (which == 0) paths[0] = tread::search_grid(c.grid, q.start, q.goal, options);
          if (which == 1) paths[1] = hashed.search(q.start, q.goal);
          if (which == 2) paths[2] = flat.search(q.start, q.goal);
        });
        sums[which] += ms;
        if (which == 0) ours_by_query[i].push_back(ms);
      };
      for (int k = 0; k < 3; ++k) run((k + repetition) % 3);
      sums[3] += milliseconds([&] {
        (void)tread::plan_waypoints(c.grid, c.grid.geometry.centre(q.start),
                                    c.grid.geometry.centre(q.goal), {});
      });
      for (int k = 1; k < 3; ++k) {
        const double largest = std::max({paths[0].cost, paths[k].cost, 1e-300});
        row.cost_difference =
            std::max(row.cost_difference, std::abs(paths[0].cost - paths[k].cost) / largest);
        if (paths[0].found != paths[k].found) row.cost_difference = kInfinity;
      }
      if (repetition == 0) {
        row.expanded += static_cast<double>(paths[0].expanded) / n;
        row.plain_expanded += static_cast<double>(paths[2].expanded) / n;
      }
    }
    for (int k = 0; k < 4; ++k) times[k].push_back(sums[k] / n);
  }
  row.ours_ms = tread::bench::median(times[0]);
  row.hashed_ms = tread::bench::median(times[1]);
  row.flat_ms = tread::bench::median(times[2]);
  row.waypoints_ms = tread::bench::median(times[3]);
  for (const auto& each : ours_by_query)
    row.longest_ms = std::max(row.longest_ms, tread::bench::median(each));
  return row;
}

void print_table(const std::vector<Row>& rows, int repetitions) {
  fmt::print("A*, ms a query (median of {} repetitions), one thread\n\n", repetitions);
  fmt::print("{:<24}{:>8}{:>9}{:>9}{:>11}{:>8}{:>9}{:>8}{:>11}{:>10}{:>10}{:>10}\n", "map",
             "queries", "tread", "longest", "textbook", "ratio", "arrays", "ratio", "waypoints",
             "expanded", "plain", "cost off");
  for (const Row& r : rows) {
    fmt::print(
        "{:<24}{:>8}{:>9.3f}{:>9.3f}{:>11.2f}{:>7.1f}x{:>9.2f}{:>7.1f}x{:>11.3f}{:>10.0f}"
        "{:>10.0f}{:>10.1e}\n",
        r.name, r.queries, r.ours_ms, r.longest_ms, r.hashed_ms, r.hashed_ms / r.ours_ms, r.flat_ms,
        r.flat_ms / r.ours_ms, r.waypoints_ms, r.expanded, r.plain_expanded, r.cost_difference);
  }
}

void print_json(const std::vector<Row>& rows, int repetitions) {
  nlohmann::json cases = nlohmann::json::array();
  for (const Row& r : rows) {
    cases.push_back({{"map", r.name},
                     {"queries", r.queries},
                     {"tread_ms", r.ours_ms},
                     {"tread_longest_ms", r.longest_ms},
                     {"textbook_ms", r.hashed_ms},
                     {"textbook_ratio", r.hashed_ms / r.ours_ms},
                     {"arrays_ms", r.flat_ms},
                     {"arrays_ratio", r.flat_ms / r.ours_ms},
                     {"plan_waypoints_ms", r.waypoints_ms},
                     {"expanded", r.expanded},
                     {"plain_expanded", r.plain_expanded},
                     {"largest_relative_cost_difference", r.cost_difference}});
  }
  const nlohmann::json all = {{"bench", "plan"}, {"repetitions", repetitions}, {"cases", cases}};
  fmt::print("{}\n", all.dump(2));
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  int repetitions = 7;
  tread::bench::Arguments arguments("plan");
  arguments.flag("--json", json).number("--repetitions", repetitions, 1);
  if (const auto status = arguments.read(argc, argv)) return *status;
  std::vector<Case> cases = {smooth_case(), seen_track_case()};
  for (const char* name : {"Berlin_0_256", "random512-10-5"}) {
    Case read;
    if (read_case(name, 40, read)) {
      cases.push_back(std::move(read));
    } else if (std::getenv("TREAD_DATA") != nullptr) {
      fmt::print(stderr, "{} cannot be read in {}: check TREAD_DATA\n", name,
                 data_folder().string());
      return 1;
    } else {
      fmt::print(stderr, "{} is not in {}: left out; set TREAD_DATA to the data folder\n", name,
                 data_folder().string());
    }
  }
  std::vector<Row> rows;
  for (const Case& c : cases) rows.push_back(measure(c, repetitions));
  json ? print_json(rows, repetitions) : print_table(rows, repetitions);
  const bool equal =
      std::all_of(rows.begin(), rows.end(), [](const Row& r) { return r.cost_difference <= 1e-9; });
  if (!equal) fmt::print(stderr, "costs differ: one of the searches is wrong\n");
  return equal ? 0 : 1;
}
