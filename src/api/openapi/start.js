// Optional parameters are not filled in with their examples when a request is tried out: these do
// not all go together. They are shown with the descriptions instead.
function withoutSuggestions(answer) {
  if (!new URL(answer.url).pathname.endsWith("/openapi.json")) {
    return answer;
  }
  const description = JSON.parse(answer.text);
  const parameters = Object.values(description.components.parameters);
  for (const parameter of parameters.filter((it) => it.example !== undefined && !it.required)) {
    parameter.description += ` Example: \`${parameter.example}\`.`;
    delete parameter.example;
  }
  answer.text = JSON.stringify(description);
  return answer;
}

// The description stands beside the page, wherever a proxy has put both.
SwaggerUIBundle({
  dom_id: "#reference",
  url: "openapi.json",
  deepLinking: true,
  defaultModelsExpandDepth: 0,
  displayRequestDuration: true,
  responseInterceptor: withoutSuggestions,
  tryItOutEnabled: false,
  validatorUrl: null,
});
