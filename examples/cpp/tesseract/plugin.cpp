// The contact checker as a plugin of tesseract: a library that `contact_manager_plugins` of a robot's configuration names, with the
// class `PunctualContactManagerFactory`. `config` may have `microseconds`, the budget of each pair of shapes.

#include "contact_manager.hpp"

#include <tesseract/collision/contact_managers_plugin_factory.h>
#include <yaml-cpp/yaml.h>

namespace punctual_tesseract {

class ContactManagerFactory : public tesseract::collision::DiscreteContactManagerFactory {
public:
  std::unique_ptr<tesseract::collision::DiscreteContactManager> create(const std::string &name,
                                                                       const YAML::Node &config) const override {
    punctual_budget budget = punctual_budget_unlimited();
    if (const YAML::Node limit = config["microseconds"])
      budget = punctual_budget_time(1000 * limit.as<std::uint64_t>());
    return std::make_unique<ContactManager>(name, budget);
  }
};

} // namespace punctual_tesseract

TESSERACT_ADD_DISCRETE_MANAGER_PLUGIN(punctual_tesseract::ContactManagerFactory, PunctualContactManagerFactory);
