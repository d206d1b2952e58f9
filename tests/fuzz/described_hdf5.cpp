#include "tests/fuzz/described_hdf5.h"

#include <hdf5.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

namespace weft::sim {

namespace {

using Sizes = std::vector<hsize_t>;

constexpr hsize_t most_values = 4096;
constexpr double most_bytes = 1 << 20;
constexpr hsize_t most_raw_bytes = 4096;

// An HDF5 identifier that is closed with the object.
class Id {
 public:
  explicit Id(hid_t id) : id_(id) {}
  ~Id() {
    if (id_ > 0) H5Idec_ref(id_);
  }
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
};

// The words of a line before "=", and its values.
struct Item {
  std::vector<std::string> words;
  std::string text;             // the rest of the line after "= "
  std::vector<double> numbers;  // of the text, or 0

  bool has(const std::string& word) const { return std::ranges::find(words, word) != words.end(); }
  // Returns the text after `key`= of an option.
  std::optional<std::string> option(const std::string& key) const {
    for (const std::string& word : words) {
      if (word.starts_with(key + '=')) return word.substr(key.size() + 1);
    }
    return std::nullopt;
  }
};

Item item_of(const std::string& line) {
  Item item;
  std::size_t end = line.find(" =");
  std::istringstream words(line.substr(0, end));
  for (std::string word; words >> word;) item.words.push_back(word);
  if (end != std::string::npos) item.text = line.substr(std::min(end + 3, line.size()));
  for (std::size_t at; (at = item.text.find("\\n")) != std::string::npos;)
    item.text.replace(at, 2, "\n");
  std::istringstream numbers(item.text);
  for (std::string number; numbers >> number && item.numbers.size() < most_values;)
    item.numbers.push_back(std::strtod(number.c_str(), nullptr));
  if (item.numbers.empty()) item.numbers.push_back(0);
  return item;
}

// Returns the sizes of a shape; none for a single value.
Sizes sizes_of(const std::string& shape) {
  Sizes sizes;
  std::istringstream text(shape);
  for (std::string size; std::getline(text, size, ',') && sizes.size() < H5S_MAX_RANK;) {
    if (size != "-") sizes.push_back(std::strtoull(size.c_str(), nullptr, 10));
  }
  return sizes;
}

double product(const Sizes& sizes) {
  double count = 1;
  for (const hsize_t size : sizes) count *= static_cast<double>(size);
  return count;
}

Id space_of(const std::string& shape, bool grows) {
  if (shape == "null") return Id(H5Screate(H5S_NULL));
  const Sizes sizes = sizes_of(shape), limits(sizes.size(), H5S_UNLIMITED);
  if (sizes.empty()) return Id(H5Screate(H5S_SCALAR));
  return Id(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(),
                             grows ? limits.data() : nullptr));
}

Id type_of(const std::string& name) {
  const auto copy = [](hid_t type) { return Id(H5Tcopy(type)); };
  if (name == "f32") return copy(H5T_IEEE_F32LE);
  if (name == "i8") return copy(H5T_STD_I8LE);
  if (name == "i32") return copy(H5T_STD_I32LE);
  if (name == "i64") return copy(H5T_STD_I64BE);
  if (name == "u64") return copy(H5T_STD_U64LE);
  if (name == "text" || name == "chars") {
    Id type = copy(H5T_C_S1);
    H5Tset_size(type, name == "text" ? H5T_VARIABLE : 8);
    return type;
  }
  if (name == "pair") {
    Id type(H5Tcreate(H5T_COMPOUND, 16));
    H5Tinsert(type, "a", 0, H5T_IEEE_F64LE);
    H5Tinsert(type, "b", 8, H5T_IEEE_F64LE);
    return type;
  }
  return copy(H5T_IEEE_F64LE);
}

Id properties_of(const Item& item) {
  Id properties(H5Pcreate(H5P_DATASET_CREATE));
  if (const auto chunk = item.option("chunk")) {
    const Sizes sizes = sizes_of(*chunk);
    if (!sizes.empty()) H5Pset_chunk(properties, static_cast<int>(sizes.size()), sizes.data());
  }
  if (item.has("shuffle")) H5Pset_shuffle(properties);
  if (item.has("deflate")) H5Pset_deflate(properties, 6);
  if (item.has("checksum")) H5Pset_fletcher32(properties);
  if (item.has("compact")) H5Pset_layout(properties, H5D_COMPACT);
  if (const auto file = item.option("external"))
    H5Pset_external(properties, file->c_str(), 0, H5F_UNLIMITED);
  if (const auto file = item.option("virtual")) {
    const Id space = space_of(item.words[3], false);
    H5Pset_virtual(properties, space, file->c_str(), "/source", space);
  }
  return properties;
}

// Writes the texts of an item by `write(type, data)`.
void write_values(const std::string& type_name, const Item& item, std::size_t count,
                  const auto& write) {
  if (type_name == "text") {
    const std::vector<const char*> texts(count, item.text.c_str());
    write(type_of("text"), texts.data());
  } else if (type_name == "chars") {
    std::string texts(8 * count, '\0');
    for (std::size_t i = 0; i < count; ++i) item.text.copy(&texts[8 * i], 8);
    write(type_of("chars"), texts.data());
  } else if (type_name == "pair") {
    const std::vector<double> numbers(2 * count, item.numbers.front());
    write(type_of("pair"), numbers.data());
  } else {
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i) numbers[i] = item.numbers[i % item.numbers.size()];
    write(Id(H5Tcopy(H5T_NATIVE_DOUBLE)), numbers.data());
  }
}

// Writes values into the part of the dataset nearest its origin.
void fill_dataset(hid_t dataset, const Item& item) {
  const Id space(H5Dget_space(dataset));
  Sizes sizes(std::max(0, H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  if (product(sizes) == 0 || H5Sget_simple_extent_type(space) == H5S_NULL) return;
  while (product(sizes) > static_cast<double>(most_values)) *std::ranges::max_element(sizes) /= 2;
  const Sizes start(sizes.size(), 0);
  if (!sizes.empty())
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, sizes.data(), nullptr);
  const Id memory =
      sizes.empty() ? Id(H5Screate(H5S_SCALAR))
                    : Id(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr));
  write_values(item.words[2], item, static_cast<std::size_t>(product(sizes)),
               [&](hid_t type, const void* data) {
                 H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, data);
               });
}

// True if HDF5 would take no more than a megabyte of memory or of the file for the values.
bool is_small(hid_t properties, const std::string& shape) {
  constexpr double bytes = 16;  // of the largest type
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (layout == H5D_VIRTUAL || H5Pget_external_count(properties) > 0) return false;
  if (layout != H5D_CHUNKED) return bytes * product(sizes_of(shape)) <= most_bytes;
  Sizes chunk(H5S_MAX_RANK, 1);
  chunk.resize(std::max(0, H5Pget_chunk(properties, H5S_MAX_RANK, chunk.data())));
  return bytes * product(chunk) <= most_bytes;
}

// True if HDF5 1.10 can write a chunk: it reads beyond its index where the dataset has no entries,
// or where chunks or their number are enormous. Such datasets stay empty.
bool can_write_chunk(hid_t properties, const std::string& shape) {
  constexpr double most_chunk_bytes = 1e9;
  constexpr hsize_t most_rows = 1'000'000'000'000;
  Sizes chunk(H5S_MAX_RANK, 1);
  chunk.resize(std::max(0, H5Pget_chunk(properties, H5S_MAX_RANK, chunk.data())));
  const Sizes sizes = sizes_of(shape);
  return product(sizes) > 0 && 16 * product(chunk) <= most_chunk_bytes &&
         std::ranges::none_of(sizes, [](hsize_t size) { return size > most_rows; });
}

// True if HDF5 1.10 can make the dataset: it copies from nowhere where a compact one has no
// entries, or where its entries lie in another file.
bool can_create(hid_t properties, const std::string& shape) {
  return H5Pget_layout(properties) != H5D_COMPACT ||
         (product(sizes_of(shape)) > 0 && H5Pget_external_count(properties) <= 0);
}

// item.words: dataset PATH TYPE SHAPE [OPTION ...]
void add_dataset(hid_t file, const Item& item) {
  const std::string &path = item.words[1], &shape = item.words[3];
  const Id properties = properties_of(item);
  if (!can_create(properties, shape)) return;
  const Id links(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(links, 1);
  const Id space = space_of(shape, H5Pget_layout(properties) == H5D_CHUNKED);
  const Id type = type_of(item.words[2]);
  const Id dataset(H5Dcreate2(file, path.c_str(), type, space, links, properties, H5P_DEFAULT));
  if (dataset < 0) return;
  if (H5Pget_layout(properties) == H5D_CHUNKED && !can_write_chunk(properties, shape)) return;
  if (const auto raw = item.option("raw")) {
    const std::vector<char> bytes(
        std::min<hsize_t>(most_raw_bytes, std::strtoull(raw->c_str(), nullptr, 10)) + 1);
    const Sizes start(H5S_MAX_RANK, 0);
    H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, start.data(), bytes.size() - 1, bytes.data());
  } else if (!item.has("empty") && is_small(properties, shape)) {
    fill_dataset(dataset, item);
  }
}

// item.words: attribute PATH NAME TYPE SHAPE
void add_attribute(hid_t file, const Item& item) {
  const Sizes sizes = sizes_of(item.words[4]);
  if (product(sizes) > static_cast<double>(most_values)) return;
  const Id object(H5Oopen(file, item.words[1].c_str(), H5P_DEFAULT));
  if (object < 0) return;
  const Id space = space_of(item.words[4], false), type = type_of(item.words[3]);
  const Id attribute(
      H5Acreate2(object, item.words[2].c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT));
  if (attribute < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) return;
  write_values(item.words[3], item, static_cast<std::size_t>(product(sizes)),
               [&](hid_t memory, const void* data) { H5Awrite(attribute, memory, data); });
}

// item.words: link PATH KIND TARGET
void add_link(hid_t file, const Item& item) {
  const char *path = item.words[1].c_str(), *target = item.words[3].c_str();
  if (item.words[2] == "soft") {
    H5Lcreate_soft(target, file, path, H5P_DEFAULT, H5P_DEFAULT);
  } else if (item.words[2] == "external") {
    H5Lcreate_external(target, "/source", file, path, H5P_DEFAULT, H5P_DEFAULT);
  } else {
    H5Lcreate_hard(file, target, file, path, H5P_DEFAULT, H5P_DEFAULT);
  }
}

void add_item(hid_t file, const Item& item) {
  const std::size_t count = item.words.size();
  const std::string kind = count == 0 ? "" : item.words[0];
  if (kind == "group" && count > 1) {
    const Id links(H5Pcreate(H5P_LINK_CREATE));
    H5Pset_create_intermediate_group(links, 1);
    const Id group(H5Gcreate2(file, item.words[1].c_str(), links, H5P_DEFAULT, H5P_DEFAULT));
  } else if (kind == "dataset" && count > 3) {
    add_dataset(file, item);
  } else if (kind == "attribute" && count > 4) {
    add_attribute(file, item);
  } else if (kind == "link" && count > 3) {
    add_link(file, item);
  }
}

}  // namespace

void write_described_file(const std::string& path, const std::vector<std::string>& lines) {
  H5E_auto2_t print = nullptr;
  void* data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &print, &data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  {
    const Id file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    for (const std::string& line : lines) add_item(file, item_of(line));
  }
  H5Eset_auto2(H5E_DEFAULT, print, data);
}

}  // namespace weft::sim
