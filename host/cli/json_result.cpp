#include "host/cli/json_result.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace stria {

using Json = nlohmann::ordered_json;

struct JsonResult::Content {
    Json object = Json::object();
};

namespace {
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
}  // namespace

JsonResult::JsonResult() : content_(std::make_unique<Content>()) {}
JsonResult::~JsonResult() = default;
JsonResult::JsonResult(const JsonResult& other)
    : content_(std::make_unique<Content>(*other.content_)) {}
JsonResult& JsonResult::operator=(const JsonResult& other) {
    *content_ = *other.content_;
    return *this;
}

JsonResult& JsonResult::set(const std::string& key, double value) {
    content_->object[key] = number(value);
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, int value) {
    content_->object[key] = value;
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, std::size_t value) {
    content_->object[key] = value;
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, bool value) {
    content_->object[key] = value;
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, const std::string& value) {
    content_->object[key] = value;
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, const char* value) {
    return set(key, std::string(value));
}
JsonResult& JsonResult::set(const std::string& key, const std::vector<double>& values) {
    Json array = Json::array();
    for (double value : values) array.push_back(number(value));
    content_->object[key] = std::move(array);
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, const std::vector<std::string>& values) {
    content_->object[key] = values;
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, const Eigen::VectorXd& values) {
    return set(key, std::vector<double>(values.begin(), values.end()));
}
JsonResult& JsonResult::set(const std::string& key, const JsonResult& object) {
    content_->object[key] = object.content_->object;
    return *this;
}
JsonResult& JsonResult::set(const std::string& key, const std::vector<JsonResult>& objects) {
    Json array = Json::array();
    for (const JsonResult& object : objects) array.push_back(object.content_->object);
    content_->object[key] = std::move(array);
    return *this;
}

std::string JsonResult::text(int indent) const {
    return content_->object.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace stria
