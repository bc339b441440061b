// The contract as bytes inside the binary.
#pragma once

#include <string_view>

namespace surfaced::proto {

/// proto/errors.json.
std::string_view errors_json();
/// proto/openapi.yaml with the schemas, as JSON.
std::string_view openapi_json();

}  // namespace surfaced::proto
