#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

namespace stria {

/// An ordered JSON object built key by key; nlohmann-json stays behind it. Numbers that are not
/// finite become null.
class JsonResult {
  public:
    JsonResult();
    ~JsonResult();
    JsonResult(const JsonResult&);
    JsonResult& operator=(const JsonResult&);

    JsonResult& set(const std::string& key, double value);
    JsonResult& set(const std::string& key, int value);
    JsonResult& set(const std::string& key, std::size_t value);
    JsonResult& set(const std::string& key, bool value);
    JsonResult& set(const std::string& key, const std::string& value);
    JsonResult& set(const std::string& key, const char* value);
    JsonResult& set(const std::string& key, const std::vector<double>& values);
    JsonResult& set(const std::string& key, const std::vector<std::string>& values);
    JsonResult& set(const std::string& key, const Eigen::VectorXd& values);
    JsonResult& set(const std::string& key, const JsonResult& object);
    JsonResult& set(const std::string& key, const std::vector<JsonResult>& objects);
    std::string text(int indent = 2) const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace stria
