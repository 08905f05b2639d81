#include "host/page/page.h"

#include <array>

#include "host/page/base64.h"
#include "host/page/style.h"

namespace fascicle::page {
namespace {

// Nothing is loaded and no script runs, even if a name managed to inject markup.
constexpr const char* policy =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

const char* class_of(Tone tone) {
  constexpr std::array<const char*, 4> classes{"neutral", "good", "warning", "bad"};
  return classes[static_cast<std::size_t>(tone)];
}

}  // namespace

Writer begin(std::string_view title, std::string_view subtitle, std::string_view state, Tone tone) {
  Writer page;
  page.start("html", {{"lang", "en"}, {"xmlns", "http://www.w3.org/1999/xhtml"}});
  page.start("head").empty("meta", {{"charset", "utf-8"}});
  page.empty("meta", {{"http-equiv", "Content-Security-Policy"}, {"content", policy}});
  page.empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}});
  page.empty("meta", {{"name", "referrer"}, {"content", "no-referrer"}});
  page.element("title", std::string(title) + " - fascicle").style(page_style).close();
  page.start("body").start("header").start("div", {{"class", "title"}}).element("h1", title);
  if (!state.empty()) page.element("span", state, {{"class", std::string("state ") + class_of(tone)}});
  page.close().element("p", subtitle, {{"class", "subtitle"}}).close();
  page.start("main");
  return page;
}

std::string finish(Writer&& page, std::string_view footer) {
  page.close().element("footer", footer).close().close();
  return "<!DOCTYPE html>\n" + std::move(page).finish();
}

void open_section(Writer& page, std::string_view id, std::string_view heading) {
  const std::string name = std::string(id) + "-heading";
  page.start("section", {{"id", std::string(id)}, {"aria-labelledby", name}});
  page.element("h2", heading, {{"id", name}});
}

void contents(Writer& page, const std::vector<std::pair<std::string, std::string>>& sections) {
  page.start("nav", {{"aria-label", "Sections"}}).start("ul");
  for (const auto& [id, heading] : sections)
    page.start("li").element("a", heading, {{"href", "#" + id}}).close();
  page.close().close();
}

void facts(Writer& page, const std::vector<Fact>& facts) {
  page.start("dl", {{"class", "facts"}});
  for (const Fact& fact : facts) {
    page.start("div", {{"class", "fact"}}).element("dt", fact.name);
    page.element("dd", fact.value, {{"class", class_of(fact.tone)}});
    if (!fact.note.empty()) page.element("dd", fact.note, {{"class", "note"}});
    page.close();
  }
  page.close();
}

void rows(Writer& page, const std::vector<std::pair<std::string, std::string>>& rows,
          std::string_view caption) {
  page.start("div", {{"class", "scroll"}}).start("table");
  if (!caption.empty()) page.element("caption", caption);
  page.start("tbody");
  for (const auto& [name, value] : rows)
    page.start("tr").element("th", name, {{"scope", "row"}}).element("td", value).close();
  page.close().close().close();
}

void table(Writer& page, const std::vector<std::vector<std::string>>& table, std::size_t first_number,
           std::string_view caption) {
  page.start("div", {{"class", "scroll"}}).start("table");
  if (!caption.empty()) page.element("caption", caption);
  for (std::size_t r = 0; r < table.size(); ++r) {
    if (r == 0) page.start("thead");
    if (r == 1) page.start("tbody");
    page.start("tr");
    for (std::size_t c = 0; c < table[r].size(); ++c) {
      Attributes attributes;
      if (r == 0) attributes.emplace_back("scope", "col");
      if (r > 0 && c == 0) attributes.emplace_back("scope", "row");
      if (c >= first_number) attributes.emplace_back("class", "number");
      page.element(r == 0 || c == 0 ? "th" : "td", table[r][c], attributes);
    }
    page.close();
    if (r == 0 || r + 1 == table.size()) page.close();
  }
  page.close().close();
}

void swatches(Writer& page, const std::vector<std::pair<std::string, std::string>>& colours) {
  page.start("ul", {{"class", "legend swatches"}});
  for (const auto& [name, colour] : colours) {
    page.start("li").start("svg", {{"class", "swatch"}, {"viewBox", "0 0 14 14"}, {"aria-hidden", "true"}});
    page.empty("rect", {{"width", "14"}, {"height", "14"}, {"fill", colour}}).close().text(name).close();
  }
  page.close();
}

void picture(Writer& page, std::string_view png, std::string_view alt, unsigned width, unsigned height) {
  page.empty("img", {{"src", "data:image/png;base64," + base64(png)},
                     {"alt", std::string(alt)},
                     {"width", std::to_string(width)},
                     {"height", std::to_string(height)}});
}

}  // namespace fascicle::page
