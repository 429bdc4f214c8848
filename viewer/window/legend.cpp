#include "viewer/window/legend.hpp"

#include <vtkCoordinate.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include "viewer/detail/scene.hpp"

namespace angio::viewer::window {

void add_legend(vtkRenderer* renderer, double left, double top,
                const std::vector<std::pair<std::string, detail::Rgb>>& words) {
  constexpr int kSize = 13, kGap = 14, kDpi = 72;
  vtkTextActor* before = nullptr;
  double offset = 0.0;
  for (const auto& [word, color] : words) {
    const auto text = detail::make_text(word, kSize, color);
    text->GetTextProperty()->SetVerticalJustificationToTop();
    vtkCoordinate* place = text->GetPositionCoordinate();
    if (before) {  // pixels to the right of the first
      place->SetCoordinateSystemToViewport();
      place->SetReferenceCoordinate(before->GetPositionCoordinate());
      place->SetValue(offset, 0.0);
    } else {
      place->SetCoordinateSystemToNormalizedViewport();
      place->SetValue(left, top);
      before = text;
    }
    int box[4] = {0, 0, 0, 0};
    vtkTextRenderer::GetInstance()->GetBoundingBox(text->GetTextProperty(), word, box, kDpi);
    offset += box[1] - box[0] + kGap;
    renderer->AddActor2D(text);
  }
}

}  // namespace angio::viewer::window
