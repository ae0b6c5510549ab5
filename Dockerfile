# Builds the service and runs it as an ordinary user; data lies in /data.
FROM rust:1.95-bookworm AS build
WORKDIR /src
COPY Cargo.toml Cargo.lock ./
COPY api ./api
COPY src ./src
COPY tests ./tests
COPY benches ./benches
RUN cargo build --release --locked --bin biotope

FROM debian:bookworm-slim
RUN useradd --system --uid 10001 --create-home --home-dir /data biotope
COPY --from=build /src/target/release/biotope /usr/local/bin/biotope
COPY --from=build /src/api/examples /usr/local/share/biotope/examples
USER 10001
VOLUME /data
EXPOSE 8080
ENTRYPOINT ["biotope"]
CMD ["serve", "--host", "0.0.0.0", "--port", "8080", "--data", "/data"]
