// SPDX-License-Identifier: Apache-2.0
//
// The samples of a plane. Copies share them until one is written to: a layer that is the whole
// picture takes neither memory nor time, and an encoder that meets the same samples again (by their
// place in memory) need not convert them twice. Read through a const object or `const` members:
// anything that may write makes shared samples its own first. As safe across threads as a
// std::vector.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace flare {

class PlaneValues {
  public:
    PlaneValues() = default;
    // What makes samples is a vector, and who reads them wants one.
    PlaneValues(std::vector<float> values)
        : values_(std::make_shared<std::vector<float>>(std::move(values))) {}
    PlaneValues(std::initializer_list<float> values) : PlaneValues(std::vector<float>(values)) {}
    operator const std::vector<float>&() const { return *values_; }

    std::size_t size() const { return values_->size(); }
    bool empty() const { return values_->empty(); }
    const float* data() const { return values_->data(); }
    float operator[](std::size_t k) const { return (*values_)[k]; }
    auto begin() const { return std::as_const(*values_).begin(); }
    auto end() const { return std::as_const(*values_).end(); }

    float* data() { return Own().data(); }
    float& operator[](std::size_t k) { return Own()[k]; }
    auto begin() { return Own().begin(); }
    auto end() { return Own().end(); }
    float& front() { return Own().front(); }
    float& back() { return Own().back(); }
    void clear() { Own().clear(); }
    template <class Place, class From>
    auto insert(Place place, From first, From last) {
        return Own().insert(place, first, last);
    }
    void push_back(float value) { Own().push_back(value); }
    void pop_back() { Own().pop_back(); }
    void resize(std::size_t count, float value = 0.0f) { Own().resize(count, value); }
    void assign(std::size_t count, float value) { Own().assign(count, value); }

    friend bool operator==(const PlaneValues& a, const PlaneValues& b) {
        return a.values_ == b.values_ || *a.values_ == *b.values_;
    }

  private:
    std::vector<float>& Own() {
        if (values_.use_count() > 1) values_ = std::make_shared<std::vector<float>>(*values_);
        return *values_;
    }

    std::shared_ptr<std::vector<float>> values_ = std::make_shared<std::vector<float>>();
};

// The first of `planes` that has its samples where plane `index` has them.
inline std::size_t FirstEqual(const std::vector<const float*>& planes, std::size_t index) {
    std::size_t first = 0;
    while (planes[first] != planes[index]) ++first;
    return first;
}

}  // namespace flare
